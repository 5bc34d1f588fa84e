// Units, one face made anew, and prisms, of a block of 2 by 2 by 1.

#include <cstdio>

#include "rvachev.hpp"

int main() {
    auto part = rvachev::part::parse("part(box(lo=(0, 0, 0), hi=(2, 2, 1)).name('b'))");
    if (!part.units().empty()) return 1;
    part.units("cm");
    const auto mesh = part.mesh(rvachev::options().set("size", "0.4"));
    const auto fine = mesh.remesh_face("b.zmax", rvachev::options().set("size", "0.1"));
    const auto prisms = mesh.sweep("b.zmin", {0, 0, -2}, 2);
    std::size_t side = 0;
    for (auto l : prisms.labels()) side += prisms.names()[l] == "b.xmin";
    std::printf("units %s before %zu after %zu cells %zu points %zu sides %zu of xmin %zu volume %.9f\n", part.units().c_str(),
                mesh.triangles_of("b.zmax").size(), fine.triangles_of("b.zmax").size(), prisms.cells().size(),
                prisms.points().size(), prisms.sides().size(), side, prisms.volume());
    const auto paired = prisms.paired();
    std::printf("paired hexahedra %zu prisms %zu of %zu volume %.9f\n", paired.hexahedra().size(), paired.cells().size(),
                prisms.cells().size(), paired.volume());
    std::vector<double> heights;
    for (const auto &p : mesh.points()) heights.push_back(p[2]);
    const auto way = mesh.path({1.5, 0.5, 1}, {2, 1.5, 0.5});
    std::printf("carried %.9f way from %.9f to %.9f\n", mesh.carry(heights, {{0, 1, 0.25}}).at(0), way.front()[0], way.back()[1]);
    const auto joined = rvachev::mesh::joined({mesh, fine});
    if (joined.triangles().size() != mesh.triangles().size() + fine.triangles().size()) return 4;
    try {
        mesh.fill_between("b.zmin", "b.xmax", 1);
        return 2;
    } catch (const rvachev::error &e) {
        std::printf("refused %d\n", e.status);
    }
    return mesh.units() == "cm" ? 0 : 3;
}

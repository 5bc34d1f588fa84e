// Faces that decide at points, pictures of comparisons, and what is told of parts built from edges. Arguments as for told.c.

#include <cstdio>

#include "rvachev.hpp"

int main(int argc, char **argv) try {
    if (argc != 5) return 2;
    const auto part = rvachev::part::parse("part(box(size=(2, 2, 2)).name('body') - cylinder(0.4, axis='x').name('bore'))");
    const auto names = part.face_names();
    std::printf("faces %zu\n", names.size());
    const char *between = "";
    for (const auto face : part.faces({{-0.95, 0.6, 0.5}, {0.1, 0.97, 0.2}, {0.1, 0, 0}, {0.7, 0.6, 1.5}, {0.8, 0.7, -1}})) {
        std::printf("%sat %s", between, names.at(static_cast<std::size_t>(face)).c_str());
        between = " ";
    }
    std::printf("\n");
    auto how = rvachev::options().set("size", "0.4");
    rvachev::compare(part, how.set("png", argv[2]));
    rvachev::compare_samples(how.set("png", argv[4]));
    rvachev::compare_triangles(argv[1], how.set("png", argv[3]).set("color", "class"));
    const auto bar = rvachev::part::parse("units('mm')\npart(extrude_edges([polyline([(0, 0), (2, 0), (2, 2), (0, 2)], closed=True)], 'z', 2))");
    std::printf("bar 0 %s\n", bar.info().c_str());
    return 0;
} catch (const rvachev::error &e) {
    std::printf("%s\n", e.what());
    return 1;
}

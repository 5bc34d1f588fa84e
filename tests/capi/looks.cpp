// Pictures, curvatures, distances, what triangles are made of, and comparisons. Arguments as for looks.c.

#include <algorithm>
#include <cstdio>

#include "rvachev.hpp"

static double covered(const rvachev::picture &p) {
    double sum = 0;
    for (const auto &pixel : p.pixels()) sum += pixel[3] / 255.0;
    return sum;
}

int main(int argc, char **argv) try {
    if (argc != 4) return 2;
    const rvachev::part part = rvachev::solid("sphere(2).name('ball')");
    const auto ball = part.mesh(rvachev::options().set("size", "0.3"));
    auto how = rvachev::options().set("pixels", "120x100").set("transparent", "true").set("legend", "false").set("edges", "none");
    how.set("focus", "0,0,0,4").set("view", "front");
    const auto picture = rvachev::draw(ball, how);
    picture.write(argv[3]);
    std::printf("picture width %zu height %zu covered %.3f\n", picture.width, picture.height, covered(picture));
    how.set("clip", "x=0,above");
    std::printf("half covered %.3f\n", covered(rvachev::draw(ball, how)));
    std::printf("far covered %.3f\n", covered(rvachev::draw(ball, how.set("color", "distance"), &part)));

    double mean = 0, most = 0, sum = 0;
    bool order = true;
    const auto bends = ball.curvatures();
    for (const auto &k : bends) {
        mean += 0.5 * (k[0] + k[1]) / static_cast<double>(bends.size());
        order = order && k[0] >= k[1];
        most = std::max(most, k[0]);
    }
    for (const auto &defect : ball.angle_defects()) sum += defect;
    const auto far = rvachev::distances(ball, part);
    std::printf("bends nodes %zu of %zu mean %.6f order %d most %.3f sum %.9f far %.3e\n", bends.size(), ball.points().size(), mean, order,
                most, sum, *std::max_element(far.begin(), far.end()));
    const auto box = rvachev::part(rvachev::solid("box(size=(2, 2, 2))")).mesh(rvachev::options().set("size", "0.3"));
    const auto classes = box.node_classes();
    const auto count = [&](int kind) { return std::count(classes.begin(), classes.end(), kind); };
    std::printf("classes corners %td creases %td regular %td\n", count(2), count(1), count(0));

    const auto file = rvachev::mesh::read(argv[1]);
    const auto points = file.points();
    const auto triangles = file.triangles();
    const rvachev::surface cube{{points.begin(), points.end()}, {triangles.begin(), triangles.end()}};
    const auto size = rvachev::options().set("size", "0.5");
    std::printf("info 0 %s\ninfo_file 0 %s\n", rvachev::info(cube).c_str(), rvachev::triangles_info(argv[1]).c_str());
    std::printf("soup 0 %s\n", rvachev::compare(cube, size).c_str());
    std::printf("soup_file 0 %s\n", rvachev::compare_triangles(argv[1], size).c_str());
    std::printf("samples 0 %s\n", rvachev::compare_samples(rvachev::options().set("size", "0.4")).c_str());
    std::printf("rsystems 0 %s\n", rvachev::compare_rsystems(rvachev::part::load(argv[2]), rvachev::options().set("size", "0.3")).c_str());
    return 0;
} catch (const rvachev::error &e) {
    std::printf("%s\n", e.what());
    return 1;
}

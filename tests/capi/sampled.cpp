// Numbers of triangles told before meshing, a function on a grid, and the outline of a figure.

#include <cmath>
#include <cstdio>

#include "rvachev.hpp"

int main(int argc, char **argv) {
    if (argc != 2) return 2;
    const auto ball = rvachev::part::parse("part(sphere(1))");
    const auto size = rvachev::options().set("size", "0.1");
    const auto made = ball.mesh(size);
    std::printf("ball about %zu made %zu step %zu contours %zu\n", ball.expected_triangles(size), made.triangles().size(),
                rvachev::expected_triangles(argv[1]), made.contour_count());

    const auto grid = ball.sample(rvachev::options().set("step", "0.25").set("margin", "0.5").set("gradient", "true"));
    const auto values = grid.values();
    const auto middle = values.size() / 2;
    std::size_t inside = 0;
    for (double v : values) inside += v > 0;
    std::printf("grid counts %zu from %.9f step %.9f inside %zu gradients %zu middle %d\n", grid.counts[0], grid.origin[2], grid.step,
                inside, grid.gradients().size(), values[middle] > 0);

    const auto mesh = rvachev::part::parse("part(region(rectangle(size=(4, 2)).name('plate')))").mesh();
    const auto line = mesh.contour(0), borders = mesh.contour_borders(0);
    const auto points = mesh.points();
    double area = 0, left = 0;
    for (std::size_t k = 0; k < line.size(); k++) {
        const auto &a = points[line[k]], &b = points[line[(k + 1) % line.size()]];
        area += (a[0] * b[1] - a[1] * b[0]) / 2;
        if (mesh.border_names()[borders[k]] == "plate.xmin") left += std::hypot(b[0] - a[0], b[1] - a[1]);
    }
    std::printf("contours %zu area %.9f left %.9f\n", mesh.contour_count(), area, left);
    return 0;
}

// A function of C++ joined to a box, meshed, watched; and an exception of the function that comes back.

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "rvachev.hpp"

using rvachev::point;
using rvachev::solid;

int main() {
    // A ball, by a function that knows its radius.
    const double radius = 1.0;
    auto distance = [radius](const point &p) { return radius - std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]); };
    const solid ball = solid::field(distance, {1.0, rvachev::box{-1.2, -1.2, -1.2, 1.2, 1.2, 1.2}, nullptr, true}).name("ball");
    const solid half = solid::box_between({-2, -2, 0}, {2, 2, 2}).name("half");

    rvachev::part part(ball & half);
    part.units("mm").group("flat", "half.zmin").group("round", "ball*");
    rvachev::run watch;
    const rvachev::mesh mesh = part.mesh(rvachev::options().set("size", "0.1").watched_by(watch));

    double volume = 0, flat = 0;
    const auto points = mesh.points();
    for (const auto &t : mesh.triangles()) {
        const point &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
        volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6;
    }
    for (auto i : mesh.triangles_of("flat")) {
        const auto &t = mesh.triangles()[i];
        const point &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
        flat -= ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2; // its normal points down
    }
    rvachev::part whole(ball);
    whole.rsystem("minmax"); // the values of the function itself, where the bounds are not near
    const auto values = whole.values({{0, 0, 0.5}, {0, 0, 1.1}});
    const auto slopes = whole.gradients({{0, 0, 0.9}});
    std::printf("half volume %.6f flat %.6f sound %d shortfalls %zu\n", volume, flat, mesh.is_sound(), mesh.shortfalls().size());
    std::printf("values inside %.6f outside %.6f slope %.6f\n", values[0], values[1], slopes[0][2]);
    std::printf("watched until %s\n", watch.progress().first.c_str());

    // Triangles of a mesh are an input again.
    const rvachev::surface surface{{points.begin(), points.end()}, {mesh.triangles().begin(), mesh.triangles().end()}};
    const rvachev::mesh again = rvachev::remesh(surface, rvachev::options().set("size", "0.2"));
    std::printf("again triangles %zu sound %d\n", again.triangles().size(), again.is_sound());

    try {
        auto broken = [](const point &p) -> double {
            if (p[0] > 0.1) throw std::domain_error("no value right of 0.1");
            return 1 - p[0] * p[0] - p[1] * p[1] - p[2] * p[2];
        };
        rvachev::part(solid::field(broken, {0, rvachev::box{-2, -2, -2, 2, 2, 2}, nullptr, true})).mesh();
        return 1;
    } catch (const std::domain_error &e) {
        std::printf("thrown %s\n", e.what());
    }
    try {
        solid("box(size=(1, 2))");
        return 1;
    } catch (const rvachev::error &e) {
        std::printf("error status %d line %zu column %zu %s\n", e.status, e.line, e.column, e.what());
    }
    return 0;
}

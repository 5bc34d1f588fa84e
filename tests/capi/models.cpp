// What is told of a STEP model, methods compared, and a mesh made brick by brick. Arguments as for models.c.

#include <cstdio>

#include "rvachev.hpp"

int main(int argc, char **argv) {
    if (argc != 5) return 2;
    const std::string plan = std::string(argv[4]) + "/plan";
    const auto check = rvachev::step_check(argv[2]), info = rvachev::step_info(argv[1]);
    std::printf("bar_check %d %s\nball_info %d %s\n", check.is_short, check.text.c_str(), info.is_short, info.text.c_str());
    const auto size = rvachev::options().set("size", "0.1");
    std::printf("compared 0 %s\n", rvachev::compare(rvachev::part::load(argv[3]), size).c_str());
    rvachev::bricks_plan(argv[3], {2, 1, 1}, plan, rvachev::options().set("size", "0.04"));
    const auto some = rvachev::bricks_make(plan, rv_share{1, 1, 1}), rest = rvachev::bricks_make(plan);
    std::printf("bricks made %zu again %zu\n", some + rest, rvachev::bricks_make(plan));
    const auto merged = rvachev::bricks_merge(plan, std::string(argv[4]) + "/cube.stl");
    std::printf("merged %d %s\n", merged.is_short, merged.text.c_str());
    return 0;
}

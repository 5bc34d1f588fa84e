// rvachev.hpp: rvachev.h for C++17. Values that free themselves, exceptions, functions of C++ as solids.
//
// Handles are counted references: copies are cheap, and the last one frees. Views lie on the memory of what they were asked of and
// live as long as it does. What goes wrong is a rvachev::error; an exception that leaves a field's function comes back as it was.

#ifndef RVACHEV_HPP
#define RVACHEV_HPP

#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "rvachev.h"

namespace rvachev {

using point = std::array<double, 3>;
using box = std::array<double, 6>; // x0 y0 z0 x1 y1 z1

// What went wrong: the status, and what is known besides the message (empty and 0 where nothing is).
class error : public std::runtime_error {
public:
    int status, user_code;
    std::string help, file;
    std::size_t line, column;

    explicit error(const rv_error *e)
        : std::runtime_error(rv_error_message(e)), status(rv_error_status(e)), user_code(rv_error_user_code(e)),
          help(text(rv_error_help(e))), file(text(rv_error_file(e))), line(rv_error_line(e)), column(rv_error_column(e)) {}

private:
    static std::string text(const char *s) { return s ? s : ""; }
};

// Items that lie in memory of the library.
template <class T> class view {
public:
    view(const T *data, std::size_t size) : data_(data), size_(size) {}
    const T *data() const { return data_; }
    std::size_t size() const { return size_; }
    const T *begin() const { return data_; }
    const T *end() const { return data_ + size_; }
    const T &operator[](std::size_t i) const { return data_[i]; }

private:
    const T *data_;
    std::size_t size_;
};

namespace detail {

// What a field's function returns after an exception: the exception is in the holder then.
constexpr int thrown = -0x7276;

struct holder {
    std::function<void(std::size_t, const double *, double *, double *)> function;
    std::mutex lock;
    std::exception_ptr exception;
};

inline int trampoline(std::size_t n, const double *xyz, double *value, double *gradient, void *user) noexcept {
    auto *h = static_cast<holder *>(user);
    try {
        h->function(n, xyz, value, gradient);
        return 0;
    } catch (...) {
        std::lock_guard<std::mutex> guard(h->lock);
        h->exception = std::current_exception();
        return thrown;
    }
}

inline void drop(void *user) noexcept { delete static_cast<holder *>(user); }

// A call whose failure is thrown; gives RV_GOOD or RV_SHORT.
template <class Call> int run(Call call) {
    rv_error *raw = nullptr;
    const int status = call(&raw);
    if (!raw) return status;
    std::unique_ptr<rv_error, void (*)(rv_error *)> e(raw, rv_error_free);
    if (rv_error_status(raw) == RV_STOPPED && rv_error_user_code(raw) == thrown) {
        auto *h = static_cast<holder *>(rv_error_user(raw));
        std::exception_ptr exception;
        {
            std::lock_guard<std::mutex> guard(h->lock);
            exception = h->exception;
        }
        if (exception) std::rethrow_exception(exception);
    }
    throw error(raw);
}

template <class T, class Call> T *made(Call call) {
    T *out = nullptr;
    run([&](rv_error **e) { return call(&out, e); });
    return out;
}

inline std::string taken(rv_text *raw) {
    std::unique_ptr<rv_text, void (*)(rv_text *)> text(raw, rv_text_free);
    return made<const char>([&](const char **out, rv_error **e) { return rv_text_chars(raw, out, e); });
}

} // namespace detail

// Cancels and watches a call, from any thread.
class run {
public:
    run() : handle_(detail::made<rv_run>(rv_run_new), rv_run_free) {}
    void cancel() const {
        detail::run([&](rv_error **e) { return rv_run_cancel(get(), e); });
    }
    // The stage, and the share of it that is done.
    std::pair<std::string, double> progress() const {
        char stage[80];
        double done = 0;
        detail::run([&](rv_error **e) { return rv_run_progress(get(), stage, sizeof stage, &done, e); });
        return {stage, done};
    }
    rv_run *get() const { return handle_.get(); }

private:
    std::shared_ptr<rv_run> handle_;
};

// Options by the names of the command: options().set("size", "2%").set("threads", "2").
class options {
public:
    options() : handle_(detail::made<rv_options>(rv_options_new), rv_options_free) {}
    options &set(const std::string &name, const std::string &value) {
        detail::run([&](rv_error **e) { return rv_options_set(get(), name.c_str(), value.c_str(), e); });
        return *this;
    }
    options &watched_by(const run &r) {
        detail::run([&](rv_error **e) { return rv_options_set_run(get(), r.get(), e); });
        return *this;
    }
    rv_options *get() const { return handle_.get(); }

private:
    std::shared_ptr<rv_options> handle_;
};

// A volume in layers of prisms: mesh::sweep and mesh::fill_between make them.
class prisms {
public:
    // Takes a handle of C.
    explicit prisms(rv_prisms *handle) : handle_(handle, rv_prisms_free) {}

    view<point> points() const & { return lent<point, double>(rv_prisms_points); }
    // Three nodes of the bottom, and those across from them.
    view<std::array<std::uint32_t, 6>> cells() const & {
        return lent<std::array<std::uint32_t, 6>, std::uint32_t>(rv_prisms_cells);
    }
    // Four nodes of the bottom, and those across from them; none unless paired() made these.
    view<std::array<std::uint32_t, 8>> hexahedra() const & {
        return lent<std::array<std::uint32_t, 8>, std::uint32_t>(rv_prisms_hexahedra);
    }
    // Hexahedra in place of pairs of prisms, at most so many degrees off rectangles; cells() are those without a partner.
    prisms paired(double off = 45) const {
        return prisms(detail::made<rv_prisms>([&](rv_prisms **p, rv_error **e) { return rv_prisms_pair(get(), off, p, e); }));
    }
    // Sides on the boundary; a triangle has its third node twice.
    view<std::array<std::uint32_t, 4>> sides() const & {
        return lent<std::array<std::uint32_t, 4>, std::uint32_t>(rv_prisms_sides);
    }
    // The name of each side, an index into names().
    view<std::uint32_t> labels() const & { return lent<std::uint32_t, std::uint32_t>(rv_prisms_labels); }
    void points() const && = delete;
    void cells() const && = delete;
    void hexahedra() const && = delete;
    void sides() const && = delete;
    void labels() const && = delete;
    std::vector<std::string> names() const {
        std::size_t n = 0;
        detail::run([&](rv_error **e) { return rv_prisms_name_count(get(), &n, e); });
        std::vector<std::string> all;
        for (std::size_t i = 0; i < n; i++)
            all.emplace_back(detail::made<const char>([&](const char **out, rv_error **e) { return rv_prisms_name(get(), i, out, e); }));
        return all;
    }
    double volume() const {
        double v = 0;
        detail::run([&](rv_error **e) { return rv_prisms_volume(get(), &v, e); });
        return v;
    }
    // vtu, msh or inp.
    void write(const std::string &path, const options &o = {}) const {
        detail::run([&](rv_error **e) { return rv_prisms_write(get(), path.c_str(), o.get(), e); });
    }
    rv_prisms *get() const { return handle_.get(); }

private:
    std::shared_ptr<rv_prisms> handle_;

    template <class T, class Part> view<T> lent(int (*ask)(const rv_prisms *, const Part **, std::size_t *, rv_error **)) const {
        static_assert(sizeof(T) % sizeof(Part) == 0 && alignof(T) == alignof(Part), "arrays have no padding");
        const Part *data = nullptr;
        std::size_t n = 0;
        detail::run([&](rv_error **e) { return ask(get(), &data, &n, e); });
        return {reinterpret_cast<const T *>(data), n};
    }
};

// A part's function on a regular grid: part::sample makes it.
class samples {
public:
    // Takes a handle of C.
    explicit samples(rv_samples *handle) : handle_(handle, rv_samples_free) {
        detail::run([&](rv_error **e) { return rv_samples_frame(get(), counts.data(), origin.data(), &step, e); });
    }

    // Points along x, y and z; the first one; the distance of neighbors.
    std::array<std::size_t, 3> counts{};
    point origin{};
    double step = 0;

    // x running fastest, then y.
    view<double> values() const & {
        const double *data = nullptr;
        std::size_t n = 0;
        detail::run([&](rv_error **e) { return rv_samples_values(get(), &data, &n, e); });
        return {data, n};
    }
    // Empty where the option "gradient" was not "true".
    view<point> gradients() const & {
        const double *data = nullptr;
        std::size_t n = 0;
        detail::run([&](rv_error **e) { return rv_samples_gradients(get(), &data, &n, e); });
        return {reinterpret_cast<const point *>(data), n};
    }
    void values() const && = delete;
    void gradients() const && = delete;
    // vti, or npy for values alone.
    void write(const std::string &path, const options &o = {}) const {
        detail::run([&](rv_error **e) { return rv_samples_write(get(), path.c_str(), o.get(), e); });
    }
    rv_samples *get() const { return handle_.get(); }

private:
    std::shared_ptr<rv_samples> handle_;
};

// Pixels, and PNG files of them: draw makes it.
class picture {
public:
    // Takes a handle of C.
    explicit picture(rv_picture *handle) : handle_(handle, rv_picture_free) {
        detail::run([&](rv_error **e) { return rv_picture_pixels(get(), &data_, &width, &height, e); });
    }

    std::size_t width = 0, height = 0;

    // Red, green, blue and opacity of each pixel, row by row from the top left.
    view<std::array<std::uint8_t, 4>> pixels() const & {
        return {reinterpret_cast<const std::array<std::uint8_t, 4> *>(data_), width * height};
    }
    void pixels() const && = delete;
    // PNG.
    void write(const std::string &path) const {
        detail::run([&](rv_error **e) { return rv_picture_write(get(), path.c_str(), e); });
    }
    rv_picture *get() const { return handle_.get(); }

private:
    std::shared_ptr<rv_picture> handle_;
    const std::uint8_t *data_ = nullptr;
};

class mesh {
public:
    // Takes a handle of C.
    explicit mesh(rv_mesh *handle) : handle_(handle, rv_mesh_free) {}

    // Meshes a part file, a STEP file, or a file of triangles, anew.
    static mesh of_file(const std::string &path, const options &o = {}) {
        return mesh(detail::made<rv_mesh>([&](rv_mesh **m, rv_error **e) { return rv_mesh_file(path.c_str(), o.get(), m, e); }));
    }
    // Reads a file of triangles as it is.
    static mesh read(const std::string &path, const options &o = {}) {
        return mesh(detail::made<rv_mesh>([&](rv_mesh **m, rv_error **e) { return rv_mesh_read(path.c_str(), o.get(), m, e); }));
    }
    // Meshes joined to one where their nodes match, up to the option "within".
    static mesh joined(const std::vector<mesh> &meshes, const options &o = {}) {
        std::vector<const rv_mesh *> all;
        for (const auto &m : meshes) all.push_back(m.get());
        return mesh(detail::made<rv_mesh>([&](rv_mesh **m, rv_error **e) { return rv_mesh_join(all.data(), all.size(), o.get(), m, e); }));
    }

    view<point> points() const & { return lent<point, double>(rv_mesh_points); }
    view<std::array<std::uint32_t, 3>> triangles() const & {
        return lent<std::array<std::uint32_t, 3>, std::uint32_t>(rv_mesh_triangles);
    }
    view<std::uint32_t> labels() const & { return lent<std::uint32_t, std::uint32_t>(rv_mesh_labels); }
    view<point> normals() const & { return lent<point, double>(rv_mesh_normals); }
    view<std::array<std::uint32_t, 2>> feature_edges() const & {
        return lent<std::array<std::uint32_t, 2>, std::uint32_t>(rv_mesh_feature_edges);
    }
    view<std::uint32_t> corners() const & { return lent<std::uint32_t, std::uint32_t>(rv_mesh_corners); }
    // Of each node the two principal curvatures, 1 over length, as magnitudes with the larger one first.
    view<std::array<double, 2>> curvatures() const & { return lent<std::array<double, 2>, double>(rv_mesh_curvatures); }
    // By how much the angles around each node differ from those where it is flat, radians.
    view<double> angle_defects() const & { return lent<double, double>(rv_mesh_angle_defects); }
    // 0 for a regular node, 1 on a crease, 2 for a corner.
    view<std::uint8_t> node_classes() const & { return lent<std::uint8_t, std::uint8_t>(rv_mesh_node_classes); }
    // Of a group, a face, or faces whose names fit a pattern.
    view<std::uint32_t> triangles_of(const std::string &name) const & { return named(rv_mesh_triangles_of, name); }
    view<std::uint32_t> nodes_of(const std::string &name) const & { return named(rv_mesh_nodes_of, name); }
    // A view would outlive a mesh that has no name.
    void points() const && = delete;
    void triangles() const && = delete;
    void labels() const && = delete;
    void normals() const && = delete;
    void feature_edges() const && = delete;
    void corners() const && = delete;
    void curvatures() const && = delete;
    void angle_defects() const && = delete;
    void node_classes() const && = delete;
    void triangles_of(const std::string &) const && = delete;
    void nodes_of(const std::string &) const && = delete;

    std::vector<std::string> face_names() const { return texts(rv_mesh_face_count, rv_mesh_face_name); }
    std::vector<std::string> group_names() const { return texts(rv_mesh_group_count, rv_mesh_group_name); }
    std::vector<std::string> warnings() const { return texts(rv_mesh_warning_count, rv_mesh_warning); }
    // Where it falls short of what was asked; empty where it does not.
    std::vector<std::string> shortfalls() const { return texts(rv_mesh_shortfall_count, rv_mesh_shortfall); }
    // The borders of a plane figure: closed lines, each node once, with the figure on the left; none for any other mesh.
    std::size_t contour_count() const {
        std::size_t n = 0;
        detail::run([&](rv_error **e) { return rv_mesh_contour_count(get(), &n, e); });
        return n;
    }
    view<std::uint32_t> contour(std::size_t index) const & { return numbered(rv_mesh_contour, index); }
    // For each of its nodes the border of the edge from it to the next one, an index into border_names().
    view<std::uint32_t> contour_borders(std::size_t index) const & { return numbered(rv_mesh_contour_borders, index); }
    void contour(std::size_t) const && = delete;
    void contour_borders(std::size_t) const && = delete;
    std::vector<std::string> border_names() const { return texts(rv_mesh_border_count, rv_mesh_border_name); }
    // JSON.
    std::string report() const {
        return detail::made<const char>([&](const char **out, rv_error **e) { return rv_mesh_report(get(), out, e); });
    }
    // "mm" and the like; empty where the part has none.
    std::string units() const {
        const auto *u = detail::made<const char>([&](const char **out, rv_error **e) { return rv_mesh_units(get(), out, e); });
        return u ? u : "";
    }
    // Another mesh with one face made anew at the option "size"; all other faces stay as they are.
    mesh remesh_face(const std::string &face, const options &o) const {
        return mesh(detail::made<rv_mesh>([&](rv_mesh **m, rv_error **e) { return rv_mesh_remesh_face(get(), face.c_str(), o.get(), m, e); }));
    }
    // HTML.
    std::string page(const std::string &title) const {
        return detail::taken(detail::made<rv_text>([&](rv_text **t, rv_error **e) { return rv_mesh_page(get(), title.c_str(), t, e); }));
    }
    // Values at the mesh's points, carried to other points: each has the value of the nearest point of the mesh.
    std::vector<double> carry(const std::vector<double> &values, const std::vector<point> &to) const {
        std::size_t n = points().size();
        if (values.size() != n) throw std::invalid_argument("one value for each point of the mesh is wanted");
        std::vector<double> out(to.size());
        static_assert(sizeof(point) == 3 * sizeof(double), "arrays have no padding");
        rv_carry what{values.data(), 1, reinterpret_cast<const double *>(to.data()), to.size(), out.data(), nullptr};
        detail::run([&](rv_error **e) { return rv_mesh_carry(get(), &what, e); });
        return out;
    }
    // The points of the shortest way over the mesh between the points of it that are nearest to two points.
    std::vector<point> path(const point &from, const point &to) const {
        std::unique_ptr<rv_path, void (*)(rv_path *)> way(
            detail::made<rv_path>([&](rv_path **p, rv_error **e) { return rv_mesh_path(get(), from.data(), to.data(), p, e); }), rv_path_free);
        const double *xyz = nullptr;
        std::size_t n = 0;
        detail::run([&](rv_error **e) { return rv_path_points(way.get(), &xyz, &n, e); });
        std::vector<point> all(n);
        for (std::size_t i = 0; i < n; i++) all[i] = {xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]};
        return all;
    }
    // What a face sweeps along a vector, in layers of prisms.
    prisms sweep(const std::string &face, const point &along, std::size_t layers) const {
        return swept({face.c_str(), nullptr, along.data(), layers});
    }
    // The room between two faces that match.
    prisms fill_between(const std::string &face, const std::string &to, std::size_t layers) const {
        return swept({face.c_str(), to.c_str(), nullptr, layers});
    }
    bool is_sound() const {
        int sound = 0;
        detail::run([&](rv_error **e) { return rv_mesh_is_sound(get(), &sound, e); });
        return sound != 0;
    }
    void write(const std::string &path, const options &o = {}) const {
        detail::run([&](rv_error **e) { return rv_mesh_write(get(), path.c_str(), o.get(), e); });
    }
    rv_mesh *get() const { return handle_.get(); }

private:
    std::shared_ptr<rv_mesh> handle_;

    prisms swept(const rv_sweep &s) const {
        return prisms(detail::made<rv_prisms>([&](rv_prisms **p, rv_error **e) { return rv_mesh_sweep(get(), &s, p, e); }));
    }

    template <class T, class Part> view<T> lent(int (*ask)(const rv_mesh *, const Part **, std::size_t *, rv_error **)) const {
        static_assert(sizeof(T) % sizeof(Part) == 0 && alignof(T) == alignof(Part), "arrays have no padding");
        const Part *data = nullptr;
        std::size_t n = 0;
        detail::run([&](rv_error **e) { return ask(get(), &data, &n, e); });
        return {reinterpret_cast<const T *>(data), n};
    }
    view<std::uint32_t> numbered(int (*ask)(const rv_mesh *, std::size_t, const std::uint32_t **, std::size_t *, rv_error **),
                                 std::size_t index) const {
        const std::uint32_t *data = nullptr;
        std::size_t n = 0;
        detail::run([&](rv_error **e) { return ask(get(), index, &data, &n, e); });
        return {data, n};
    }
    view<std::uint32_t> named(int (*ask)(const rv_mesh *, const char *, const std::uint32_t **, std::size_t *, rv_error **),
                              const std::string &name) const {
        const std::uint32_t *data = nullptr;
        std::size_t n = 0;
        detail::run([&](rv_error **e) { return ask(get(), name.c_str(), &data, &n, e); });
        return {data, n};
    }
    std::vector<std::string> texts(int (*count)(const rv_mesh *, std::size_t *, rv_error **),
                                   int (*text)(const rv_mesh *, std::size_t, const char **, rv_error **)) const {
        std::size_t n = 0;
        detail::run([&](rv_error **e) { return count(get(), &n, e); });
        std::vector<std::string> all;
        for (std::size_t i = 0; i < n; i++)
            all.emplace_back(detail::made<const char>([&](const char **out, rv_error **e) { return text(get(), i, out, e); }));
        return all;
    }
};

// What is said of a field besides its function.
struct about_field {
    double lipschitz = 0;                                    // values change by at most this much per length; 0: not known
    std::optional<box> bounds = std::nullopt;                // called inside only, cut off there
    std::function<point(const point &)> gradient = nullptr;  // differences of values without
    bool concurrent = false;                                 // whether several threads may call it at once
};

class solid {
public:
    // As part files have it: "box(size=(2, 2, 2)) - cylinder(0.4)".
    explicit solid(const std::string &text)
        : solid(detail::made<rv_solid>([&](rv_solid **s, rv_error **e) { return rv_solid_parse(text.c_str(), s, e); })) {}
    // Takes a handle of C.
    explicit solid(rv_solid *handle) : handle_(handle, rv_solid_free) {}

    // Where a function is positive. See rv_field for what is asked of it.
    static solid field(std::function<double(const point &)> f, about_field about = {}) {
        auto h = std::make_unique<detail::holder>();
        const bool has_gradient = bool(about.gradient);
        h->function = [f = std::move(f), g = about.gradient](std::size_t n, const double *xyz, double *value, double *gradient) {
            for (std::size_t i = 0; i < n; i++) {
                const point p{xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]};
                value[i] = f(p);
                if (!gradient) continue;
                const point slope = g(p);
                for (std::size_t k = 0; k < 3; k++) gradient[3 * i + k] = slope[k];
            }
        };
        rv_field said{};
        said.function = detail::trampoline;
        said.user = h.get();
        said.release = detail::drop;
        said.lipschitz = about.lipschitz;
        said.bounds = about.bounds ? about.bounds->data() : nullptr;
        said.has_gradient = has_gradient;
        said.concurrent = about.concurrent;
        solid made(detail::made<rv_solid>([&](rv_solid **s, rv_error **e) { return rv_solid_field(&said, s, e); }));
        h.release(); // the library's now
        return made;
    }
    // Values on a grid of points, x running fastest, trilinear between them.
    static solid grid(const std::array<std::size_t, 3> &counts, const box &bounds, const std::vector<double> &values) {
        if (values.size() != counts[0] * counts[1] * counts[2]) throw std::invalid_argument("a grid needs a value for each point");
        return make([&](auto s, auto e) { return rv_solid_grid(counts.data(), bounds.data(), values.data(), s, e); });
    }
    static solid box_between(const point &lo, const point &hi) {
        return make([&](auto s, auto e) { return rv_solid_box(lo.data(), hi.data(), s, e); });
    }
    static solid sphere(double r, const point &at = {}) {
        return make([&](auto s, auto e) { return rv_solid_sphere(r, at.data(), s, e); });
    }
    static solid cylinder(double r, const point &from, const point &to) {
        return make([&](auto s, auto e) { return rv_solid_cylinder(r, from.data(), to.data(), s, e); });
    }
    static solid cone(double r0, double r1, const point &from, const point &to) {
        const double radii[2] = {r0, r1};
        return make([&](auto s, auto e) { return rv_solid_cone(radii, from.data(), to.data(), s, e); });
    }
    static solid torus(double ring, double tube, const point &axis = {0, 0, 1}, const point &at = {}) {
        const double radii[2] = {ring, tube};
        return make([&](auto s, auto e) { return rv_solid_torus(radii, axis.data(), at.data(), s, e); });
    }
    static solid half_space(const point &normal, const point &at = {}) {
        return make([&](auto s, auto e) { return rv_solid_half_space(normal.data(), at.data(), s, e); });
    }

    friend solid operator|(const solid &a, const solid &b) { return pair(rv_solid_union, a, b); }
    friend solid operator&(const solid &a, const solid &b) { return pair(rv_solid_intersection, a, b); }
    friend solid operator-(const solid &a, const solid &b) {
        return make([&](auto s, auto e) { return rv_solid_difference(a.get(), b.get(), s, e); });
    }
    solid operator~() const {
        return make([&](auto s, auto e) { return rv_solid_complement(get(), s, e); });
    }
    friend solid blend(const solid &a, const solid &b, double radius) {
        return make([&](auto s, auto e) { return rv_solid_blend(a.get(), b.get(), radius, s, e); });
    }
    solid name(const std::string &n) const {
        return make([&](auto s, auto e) { return rv_solid_name(get(), n.c_str(), s, e); });
    }
    solid size(double h) const {
        return make([&](auto s, auto e) { return rv_solid_size(get(), h, s, e); });
    }
    solid move(const point &by) const {
        return make([&](auto s, auto e) { return rv_solid_move(get(), by.data(), s, e); });
    }
    solid rotate(double degrees, const point &axis = {0, 0, 1}) const {
        return make([&](auto s, auto e) { return rv_solid_rotate(get(), degrees, axis.data(), s, e); });
    }
    solid scale(double k) const {
        return make([&](auto s, auto e) { return rv_solid_scale(get(), k, s, e); });
    }
    // Methods of part files: "rotate(90, at=(1, 0, 0)).mirror(\"x\")".
    solid apply(const std::string &methods) const {
        return make([&](auto s, auto e) { return rv_solid_apply(get(), methods.c_str(), s, e); });
    }
    rv_solid *get() const { return handle_.get(); }

private:
    std::shared_ptr<rv_solid> handle_;

    template <class Call> static solid make(Call call) {
        return solid(detail::made<rv_solid>([&](rv_solid **s, rv_error **e) { return call(s, e); }));
    }
    static solid pair(int (*join)(const rv_solid *const *, std::size_t, rv_solid **, rv_error **), const solid &a, const solid &b) {
        const rv_solid *both[2] = {a.get(), b.get()};
        return make([&](auto s, auto e) { return join(both, 2, s, e); });
    }
};

class part {
public:
    part(const solid &s) : part(std::vector<solid>{s}) {}
    explicit part(const std::vector<solid> &solids) {
        std::vector<const rv_solid *> all;
        for (const auto &s : solids) all.push_back(s.get());
        reset(detail::made<rv_part>([&](rv_part **p, rv_error **e) { return rv_part_new(all.data(), all.size(), p, e); }));
    }
    // The text of a part file.
    static part parse(const std::string &text, const options &o = {}) {
        return part(detail::made<rv_part>([&](rv_part **p, rv_error **e) { return rv_part_parse(text.c_str(), o.get(), p, e); }));
    }
    static part load(const std::string &path, const options &o = {}) {
        return part(detail::made<rv_part>([&](rv_part **p, rv_error **e) { return rv_part_load(path.c_str(), o.get(), p, e); }));
    }
    // Takes a handle of C.
    explicit part(rv_part *handle) { reset(handle); }

    part &units(const std::string &u) {
        detail::run([&](rv_error **e) { return rv_part_set_units(get(), u.c_str(), e); });
        return *this;
    }
    // Empty where none was said.
    std::string units() const {
        const auto *u = detail::made<const char>([&](const char **out, rv_error **e) { return rv_part_units(get(), out, e); });
        return u ? u : "";
    }
    part &rsystem(const std::string &r) {
        detail::run([&](rv_error **e) { return rv_part_set_rsystem(get(), r.c_str(), e); });
        return *this;
    }
    part &domain(const box &b) {
        detail::run([&](rv_error **e) { return rv_part_set_domain(get(), b.data(), e); });
        return *this;
    }
    part &group(const std::string &name, const std::string &faces) {
        detail::run([&](rv_error **e) { return rv_part_group(get(), name.c_str(), faces.c_str(), e); });
        return *this;
    }
    std::string info() const {
        return detail::taken(detail::made<rv_text>([&](rv_text **t, rv_error **e) { return rv_part_info(get(), t, e); }));
    }
    std::vector<double> values(const std::vector<point> &at) const {
        std::vector<double> out(at.size());
        detail::run([&](rv_error **e) { return rv_part_values(get(), at.size(), numbers(at), out.data(), e); });
        return out;
    }
    std::vector<point> gradients(const std::vector<point> &at) const {
        std::vector<point> out(at.size());
        auto *to = reinterpret_cast<double *>(out.data());
        detail::run([&](rv_error **e) { return rv_part_gradients(get(), at.size(), numbers(at), to, e); });
        return out;
    }
    // The face at points, an index into face_names(); -1 where none decides.
    std::vector<std::int32_t> faces(const std::vector<point> &at) const {
        std::vector<std::int32_t> out(at.size());
        detail::run([&](rv_error **e) { return rv_part_faces(get(), at.size(), numbers(at), out.data(), e); });
        return out;
    }
    std::vector<std::string> face_names() const {
        std::size_t n = 0;
        detail::run([&](rv_error **e) { return rv_part_face_count(get(), &n, e); });
        std::vector<std::string> out;
        for (std::size_t i = 0; i < n; i++)
            out.push_back(detail::taken(detail::made<rv_text>([&](rv_text **t, rv_error **e) { return rv_part_face_name(get(), i, t, e); })));
        return out;
    }
    rvachev::mesh mesh(const options &o = {}) const {
        return rvachev::mesh(detail::made<rv_mesh>([&](rv_mesh **m, rv_error **e) { return rv_part_mesh(get(), o.get(), m, e); }));
    }
    // About how many triangles that mesh will have.
    std::size_t expected_triangles(const options &o = {}) const {
        std::size_t n = 0;
        detail::run([&](rv_error **e) { return rv_expected_triangles(get(), o.get(), &n, e); });
        return n;
    }
    // The function on a regular grid: options cells or step, margin, gradient.
    samples sample(const options &o = {}) const {
        return samples(detail::made<rv_samples>([&](rv_samples **s, rv_error **e) { return rv_part_sample(get(), o.get(), s, e); }));
    }
    // step, stp, vm or 3mf.
    void write(const std::string &path) const {
        detail::run([&](rv_error **e) { return rv_part_write(get(), path.c_str(), e); });
    }
    void write_step(const std::string &path) const {
        detail::run([&](rv_error **e) { return rv_part_write_step(get(), path.c_str(), e); });
    }
    rv_part *get() const { return handle_.get(); }

private:
    std::shared_ptr<rv_part> handle_;

    void reset(rv_part *handle) { handle_.reset(handle, rv_part_free); }
    static const double *numbers(const std::vector<point> &p) { return reinterpret_cast<const double *>(p.data()); }
};

// Draws a mesh: see rv_mesh_picture for the options. The part is for the color distance.
inline picture draw(const mesh &m, const options &o = {}, const part *against = nullptr) {
    const rv_part *p = against ? against->get() : nullptr;
    return picture(detail::made<rv_picture>([&](rv_picture **out, rv_error **e) { return rv_mesh_picture(m.get(), p, o.get(), out, e); }));
}
// How far each node of a mesh is from the surface of a part; infinite where it is far from all of it.
inline std::vector<double> distances(const mesh &m, const part &p, const options &o = {}) {
    std::vector<double> out(m.points().size());
    detail::run([&](rv_error **e) { return rv_mesh_distances(m.get(), p.get(), o.get(), out.data(), e); });
    return out;
}

// A surface in arrays: points, and three of them for each triangle.
struct surface {
    std::vector<point> points;
    std::vector<std::array<std::uint32_t, 3>> triangles;

    rv_surface get() const {
        return {reinterpret_cast<const double *>(points.data()), points.size(),
                reinterpret_cast<const std::uint32_t *>(triangles.data()), triangles.size()};
    }
};

// About how many triangles the mesh of a file will have.
inline std::size_t expected_triangles(const std::string &path, const options &o = {}) {
    std::size_t n = 0;
    detail::run([&](rv_error **e) { return rv_expected_triangles_file(path.c_str(), o.get(), &n, e); });
    return n;
}
// A text, and whether what it tells of falls short: the status was RV_SHORT.
struct told {
    std::string text;
    bool is_short;
};
namespace detail {
template <class Call> told tell(Call call) {
    rv_text *out = nullptr;
    const int status = run([&](rv_error **e) { return call(&out, e); });
    return {taken(out), status == RV_SHORT};
}
} // namespace detail

// What is wrong with the model of a STEP file, as JSON.
inline told step_check(const std::string &path, const options &o = {}) {
    return detail::tell([&](rv_text **t, rv_error **e) { return rv_step_check(path.c_str(), o.get(), t, e); });
}
// What is in it, as JSON.
inline told step_info(const std::string &path, const options &o = {}) {
    return detail::tell([&](rv_text **t, rv_error **e) { return rv_step_info(path.c_str(), o.get(), t, e); });
}
// Every stage of every method measured on a part, as JSON.
inline std::string compare(const part &p, const options &o = {}) {
    return detail::tell([&](rv_text **t, rv_error **e) { return rv_compare(p.get(), o.get(), t, e); }).text;
}
// R-systems compared on a part, as JSON.
inline std::string compare_rsystems(const part &p, const options &o = {}) {
    return detail::tell([&](rv_text **t, rv_error **e) { return rv_compare_rsystems(p.get(), o.get(), t, e); }).text;
}
// Every method measured on the samples that come with the library, as JSON.
inline std::string compare_samples(const options &o = {}) {
    return detail::tell([&](rv_text **t, rv_error **e) { return rv_compare_samples(o.get(), t, e); }).text;
}
// A surface, or a file of triangles, measured beside what methods make of it, as JSON.
inline std::string compare(const surface &s, const options &o = {}) {
    const rv_surface raw = s.get();
    return detail::tell([&](rv_text **t, rv_error **e) { return rv_compare_triangles(&raw, o.get(), t, e); }).text;
}
inline std::string compare_triangles(const std::string &path, const options &o = {}) {
    return detail::tell([&](rv_text **t, rv_error **e) { return rv_compare_triangles_file(path.c_str(), o.get(), t, e); }).text;
}
// Faces, edges and vertices that are found in a surface, or in a file of triangles, as JSON.
inline std::string info(const surface &s, const options &o = {}) {
    const rv_surface raw = s.get();
    return detail::tell([&](rv_text **t, rv_error **e) { return rv_triangles_info(&raw, o.get(), t, e); }).text;
}
inline std::string triangles_info(const std::string &path, const options &o = {}) {
    return detail::tell([&](rv_text **t, rv_error **e) { return rv_triangles_info_file(path.c_str(), o.get(), t, e); }).text;
}

// A plan of bricks for a part file, in a folder.
inline void bricks_plan(const std::string &path, const std::array<std::uint32_t, 3> &counts, const std::string &folder, const options &o = {}) {
    detail::run([&](rv_error **e) { return rv_bricks_plan(path.c_str(), counts.data(), o.get(), folder.c_str(), e); });
}
// Makes the bricks of a share, or all of them; how many pieces were made.
inline std::size_t bricks_make(const std::string &folder, const std::optional<rv_share> &share = std::nullopt, const options &o = {}) {
    std::size_t made = 0;
    detail::run([&](rv_error **e) { return rv_bricks_make(folder.c_str(), share ? &*share : nullptr, o.get(), &made, e); });
    return made;
}
// Writes the mesh of all bricks to a file; the report as JSON.
inline told bricks_merge(const std::string &folder, const std::string &path, const options &o = {}) {
    return detail::tell([&](rv_text **t, rv_error **e) { return rv_bricks_merge(folder.c_str(), path.c_str(), o.get(), t, e); });
}
inline mesh remesh(const surface &s, const options &o = {}) {
    const rv_surface raw = s.get();
    return mesh(detail::made<rv_mesh>([&](rv_mesh **m, rv_error **e) { return rv_remesh(&raw, o.get(), m, e); }));
}
inline mesh heal(const surface &s, const options &o = {}) {
    const rv_surface raw = s.get();
    return mesh(detail::made<rv_mesh>([&](rv_mesh **m, rv_error **e) { return rv_heal(&raw, o.get(), m, e); }));
}
// Measures as JSON, against a part where one is given.
inline std::string check(const surface &s, const part *against = nullptr, const options &o = {}) {
    const rv_surface raw = s.get();
    const rv_part *p = against ? against->get() : nullptr;
    return detail::taken(detail::made<rv_text>([&](rv_text **t, rv_error **e) { return rv_check(&raw, p, o.get(), t, e); }));
}
inline std::string check_file(const surface &s, const std::string &path, const options &o = {}) {
    const rv_surface raw = s.get();
    return detail::taken(
        detail::made<rv_text>([&](rv_text **t, rv_error **e) { return rv_check_file(&raw, path.c_str(), o.get(), t, e); }));
}

} // namespace rvachev

#endif

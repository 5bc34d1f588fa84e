/* A part file's text becomes arrays: its volume, the area of a group, and a file. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "rvachev.h"

static const char *PART = "units('mm')\n"
                          "body = box(size=(2, 2, 2)).name('body')\n"
                          "bore = cylinder(0.5).name('bore')\n"
                          "part(body - bore)\n"
                          "group('held', faces('bore'))\n";

/* Says what went wrong and ends. */
static void need(int status, rv_error *error) {
    if (status == RV_GOOD) return;
    fprintf(stderr, "status %d: %s\n", status, error ? rv_error_message(error) : "falls short of what was asked");
    if (rv_error_help(error)) fprintf(stderr, "help: %s\n", rv_error_help(error));
    exit(status);
}

/* Twice the area of a triangle, as a vector. */
static void cross(const double *p, const uint32_t *t, double out[3]) {
    double a[3], b[3];
    for (int k = 0; k < 3; k++) {
        a[k] = p[3 * t[1] + k] - p[3 * t[0] + k];
        b[k] = p[3 * t[2] + k] - p[3 * t[0] + k];
    }
    for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

int main(int argc, char **argv) {
    rv_error *error = NULL;
    rv_part *part = NULL;
    rv_options *options = NULL;
    rv_mesh *mesh = NULL;
    need(rv_part_parse(PART, NULL, &part, &error), error);
    need(rv_options_new(&options, &error), error);
    need(rv_options_set(options, "size", "3%", &error), error);
    need(rv_part_mesh(part, options, &mesh, &error), error);

    const double *p, *normals;
    const uint32_t *t, *labels, *held, *nodes, *edges;
    size_t n, m, n_labels, n_normals, n_held, n_nodes, n_edges, n_faces;
    need(rv_mesh_points(mesh, &p, &n, &error), error);
    need(rv_mesh_triangles(mesh, &t, &m, &error), error);
    need(rv_mesh_labels(mesh, &labels, &n_labels, &error), error);
    need(rv_mesh_normals(mesh, &normals, &n_normals, &error), error);
    need(rv_mesh_feature_edges(mesh, &edges, &n_edges, &error), error);
    need(rv_mesh_triangles_of(mesh, "held", &held, &n_held, &error), error);
    need(rv_mesh_nodes_of(mesh, "held", &nodes, &n_nodes, &error), error);
    need(rv_mesh_face_count(mesh, &n_faces, &error), error);

    double volume = 0, area = 0, off = 0, v[3];
    for (size_t i = 0; i < m; i++) {
        cross(p, t + 3 * i, v);
        for (int k = 0; k < 3; k++) volume += p[3 * t[3 * i] + k] * v[k] / 6;
    }
    for (size_t i = 0; i < n_held; i++) {
        cross(p, t + 3 * held[i], v);
        area += sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) / 2;
    }
    for (size_t i = 0; i < n_nodes; i++) off = fmax(off, fabs(hypot(p[3 * nodes[i]], p[3 * nodes[i] + 1]) - 0.5));
    int sound = 0;
    need(rv_mesh_is_sound(mesh, &sound, &error), error);
    printf("points %zu triangles %zu labels %zu normals %zu feature_edges %zu faces %zu sound %d\n", n, m, n_labels, n_normals,
           n_edges, n_faces, sound);
    for (size_t i = 0; i < n_faces; i++) {
        const char *name;
        need(rv_mesh_face_name(mesh, i, &name, &error), error);
        printf("face %s\n", name);
    }
    printf("volume %.6f area_held %.6f off_held %.3e\n", volume, area, off);

    const char *report;
    need(rv_mesh_report(mesh, &report, &error), error);
    printf("report %.12s\n", report);
    if (argc > 1) need(rv_mesh_write(mesh, argv[1], NULL, &error), error);

    rv_mesh_free(mesh);
    rv_options_free(options);
    rv_part_free(part);
    return 0;
}

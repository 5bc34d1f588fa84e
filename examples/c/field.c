/* A function of C as the solid, and the same values on a grid: a ball with a bore, and its volume both ways. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "rvachev.h"

typedef struct {
    double radius;
} ball;

/* The distance to a sphere, positive inside, with its gradient. */
static int distance(size_t n, const double *xyz, double *value, double *gradient, void *user) {
    const ball *b = user;
    for (size_t i = 0; i < n; i++) {
        const double *p = xyz + 3 * i;
        double r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        value[i] = b->radius - r;
        if (gradient)
            for (int k = 0; k < 3; k++) gradient[3 * i + k] = r > 0 ? -p[k] / r : 0;
    }
    return 0;
}

static void need(int status, rv_error *error) {
    if (status == RV_GOOD) return;
    fprintf(stderr, "status %d: %s\n", status, error ? rv_error_message(error) : "falls short of what was asked");
    exit(status);
}

/* Meshes what is left of a solid after a bore along z, and tells its volume. Takes the solid. */
static void tell(const char *name, rv_solid *solid) {
    const double from[3] = {0, 0, -2}, to[3] = {0, 0, 2};
    rv_error *error = NULL;
    rv_solid *bore = NULL, *named = NULL, *rest = NULL;
    rv_part *part = NULL;
    rv_options *options = NULL;
    rv_mesh *mesh = NULL;
    need(rv_solid_cylinder(0.4, from, to, &bore, &error), error);
    need(rv_solid_name(bore, "bore", &named, &error), error);
    need(rv_solid_difference(solid, named, &rest, &error), error);
    const rv_solid *all[1] = {rest};
    need(rv_part_new(all, 1, &part, &error), error);
    need(rv_options_new(&options, &error), error);
    need(rv_options_set(options, "size", "0.12", &error), error);
    need(rv_part_mesh(part, options, &mesh, &error), error);

    const double *p;
    const uint32_t *t, *bored;
    size_t n, m, n_bored;
    need(rv_mesh_points(mesh, &p, &n, &error), error);
    need(rv_mesh_triangles(mesh, &t, &m, &error), error);
    need(rv_mesh_triangles_of(mesh, "bore*", &bored, &n_bored, &error), error);
    double volume = 0;
    for (size_t i = 0; i < m; i++, t += 3) {
        const double *a = p + 3 * t[0], *b = p + 3 * t[1], *c = p + 3 * t[2];
        volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6;
    }
    printf("%s volume %.6f triangles %zu bore %zu\n", name, volume, m, n_bored);

    rv_mesh_free(mesh);
    rv_options_free(options);
    rv_part_free(part);
    rv_solid_free(rest);
    rv_solid_free(named);
    rv_solid_free(bore);
    rv_solid_free(solid);
}

int main(void) {
    const double bounds[6] = {-1.2, -1.2, -1.2, 1.2, 1.2, 1.2};
    ball data = {1.0};
    rv_error *error = NULL;
    rv_solid *solid = NULL;
    /* It only reads its data, so several threads may call it at once. */
    rv_field field = {.function = distance, .user = &data, .lipschitz = 1, .bounds = bounds, .has_gradient = 1, .concurrent = 1};
    need(rv_solid_field(&field, &solid, &error), error);
    tell("function", solid);

    enum { N = 41 };
    const size_t counts[3] = {N, N, N};
    double *values = malloc(sizeof(double) * N * N * N);
    if (!values) return RV_FAILED;
    for (int k = 0; k < N; k++)
        for (int j = 0; j < N; j++)
            for (int i = 0; i < N; i++) {
                double p[3] = {-1.2 + 2.4 * i / (N - 1), -1.2 + 2.4 * j / (N - 1), -1.2 + 2.4 * k / (N - 1)};
                distance(1, p, values + i + N * (j + N * k), NULL, &data);
            }
    need(rv_solid_grid(counts, bounds, values, &solid, &error), error);
    free(values);
    tell("grid", solid);
    return 0;
}

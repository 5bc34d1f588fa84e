/* Numbers of triangles told before meshing, options of meshing, functions on grids, and outlines of figures. The first argument is a
 * STEP file of a sphere, the second a folder for files. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "need.h"

/* Options of one name, and of a second one where that is not NULL. */
static rv_options *with(const char *name, const char *value, const char *second, const char *other) {
    rv_options *o = NULL;
    if (rv_options_new(&o, NULL) || rv_options_set(o, name, value, NULL) || (second && rv_options_set(o, second, other, NULL))) exit(9);
    return o;
}

/* Volume, and the largest distance of a triangle's middle from the unit sphere. */
static size_t measured(const rv_mesh *mesh, double *volume, double *off) {
    const double *p;
    const uint32_t *t;
    size_t n, m;
    rv_mesh_points(mesh, &p, &n, NULL), rv_mesh_triangles(mesh, &t, &m, NULL);
    *volume = *off = 0;
    for (size_t i = 0; i < m; i++) {
        const double *a = p + 3 * t[3 * i], *b = p + 3 * t[3 * i + 1], *c = p + 3 * t[3 * i + 2];
        *volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6;
        double x = (a[0] + b[0] + c[0]) / 3, y = (a[1] + b[1] + c[1]) / 3, z = (a[2] + b[2] + c[2]) / 3;
        *off = fmax(*off, fabs(1 - sqrt(x * x + y * y + z * z)));
    }
    return m;
}

static int counted(const rv_part *ball, const char *step) {
    rv_options *size = with("size", "0.1", NULL, NULL), *bad = with("sequence", "R_all*2 N*10 N1", NULL, NULL);
    rv_mesh *mesh, *file;
    size_t about, n;
    double volume, off;
    NEED(rv_expected_triangles(ball, size, &about, &error));
    NEED(rv_part_mesh(ball, size, &mesh, &error));
    printf("ball about %zu made %zu\n", about, measured(mesh, &volume, &off));
    NEED(rv_expected_triangles_file(step, NULL, &about, &error));
    NEED(rv_mesh_file(step, NULL, &file, &error));
    printf("step about %zu made %zu\n", about, measured(file, &volume, &off));
    WRONG(rv_expected_triangles(NULL, NULL, &n, &error), RV_USAGE, "part is NULL");
    WRONG(rv_expected_triangles(ball, NULL, NULL, &error), RV_USAGE, "count is NULL");
    WRONG(rv_expected_triangles_file(NULL, NULL, &n, &error), RV_USAGE, "path is NULL");
    WRONG(rv_expected_triangles_file("no.step", NULL, &n, &error), RV_INPUT, "no.step");
    WRONG(rv_expected_triangles_file(step, bad, &n, &error), RV_USAGE, "sequence");
    rv_mesh_free(mesh), rv_mesh_free(file), rv_options_free(size), rv_options_free(bad);
    return 0;
}

static int options_of_meshing(const rv_part *ball, const char *step) {
    /* The diagonal of the ball's box is 2 * sqrt(3). */
    rv_options *share = with("size", "40%", "tol", "0.1%"), *length = with("size", "40%", "tol", "0.0034641016151377548");
    rv_options *lost = with("volume", "0.001", NULL, NULL), *without = with("without", "halving", "without", "trim");
    rv_options *order = with("sequence", "R_all*2 N*10 N1", "size", "0.2"), *none;
    rv_mesh *a, *b, *mesh;
    const char *report;
    double va, vb, off;
    NEED(rv_part_mesh(ball, share, &a, &error));
    NEED(rv_part_mesh(ball, length, &b, &error));
    size_t na = measured(a, &va, &off), nb = measured(b, &vb, &off);
    printf("tolerance share %zu length %zu off %.9f\n", na, nb, off);
    WRONG(rv_part_mesh(ball, lost, &mesh, &error), RV_USAGE, "volume");
    WRONG(rv_part_mesh(ball, without, &mesh, &error), RV_USAGE, "remedies");
    NEED(rv_mesh_file(step, without, &mesh, &error));
    rv_mesh_free(mesh);
    NEED(rv_mesh_file(step, lost, &mesh, &error));
    measured(mesh, &va, &off);
    printf("lost volume %.9f\n", va);
    rv_mesh_free(mesh);
    int status = rv_part_mesh(ball, order, &mesh, &error);
    if (status > RV_SHORT) printf("sequence: %s\n", rv_error_message(error));
    NEED(rv_mesh_report(mesh, &report, &error));
    measured(mesh, &va, &off);
    printf("sequence told %d volume %.9f\n", strstr(report, "\"operators\"") && strstr(report, "R_all*2 N*10 N1"), va);
    NEED(rv_options_new(&none, &error));
    WRONG(rv_options_set(none, "sequence", "R_all*2 M", &error), RV_USAGE, "line 1, column 9");
    WRONG(rv_options_set(none, "without", "luck", &error), RV_USAGE, "no remedy \"luck\"");
    WRONG(rv_options_set(none, "volume", "1", &error), RV_USAGE, "below 1");
    WRONG(rv_options_set(none, "tol", "-1%", &error), RV_USAGE, "-1%");
    rv_mesh_free(a), rv_mesh_free(b), rv_mesh_free(mesh);
    rv_options_free(share), rv_options_free(length), rv_options_free(lost), rv_options_free(without), rv_options_free(order);
    rv_options_free(none);
    return 0;
}

static int grids(const rv_part *ball, const char *folder) {
    rv_options *how = with("cells", "40", "gradient", "true"), *plain = with("step", "0.25", "margin", "0.5"), *memory;
    rv_samples *samples, *few, *none;
    rv_solid *solid;
    rv_part *again;
    rv_mesh *mesh;
    size_t counts[3], n, m, inside = 0, wrong = 0;
    double origin[3], step, turned = 0, apart = 0, volume, off;
    const double *values, *slopes;
    char path[1000];
    NEED(rv_part_sample(ball, how, &samples, &error));
    NEED(rv_samples_frame(samples, counts, origin, &step, &error));
    NEED(rv_samples_values(samples, &values, &n, &error));
    NEED(rv_samples_gradients(samples, &slopes, &m, &error));
    for (size_t i = 0; i < n; i++) {
        double p[3] = {origin[0] + step * (double)(i % counts[0]), origin[1] + step * (double)(i / counts[0] % counts[1]),
                       origin[2] + step * (double)(i / counts[0] / counts[1])};
        double r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]), value;
        if (i % 997 == 0) { /* what a call for one point says */
            NEED(rv_part_values(ball, 1, p, &value, &error));
            apart = fmax(apart, fabs(value - values[i]));
        }
        inside += values[i] > 0;
        wrong += fabs(r - 1) > 1e-9 && (values[i] > 0) != (r < 1);
        if (r > 0.1) /* towards the middle */
            for (int k = 0; k < 3; k++) turned = fmax(turned, fabs(slopes[3 * i + k] / sqrt(slopes[3 * i] * slopes[3 * i] + slopes[3 * i + 1] * slopes[3 * i + 1] + slopes[3 * i + 2] * slopes[3 * i + 2]) + p[k] / r));
    }
    printf("grid counts %zu %zu %zu values %zu gradients %zu wrong %zu apart %g turned %g volume %.9f\n", counts[0], counts[1], counts[2],
           n, m, wrong, apart, turned, (double)inside * step * step * step);
    /* The values are a solid again. */
    double bounds[6] = {origin[0], origin[1], origin[2], origin[0] + step * (double)(counts[0] - 1),
                        origin[1] + step * (double)(counts[1] - 1), origin[2] + step * (double)(counts[2] - 1)};
    NEED(rv_solid_grid(counts, bounds, values, &solid, &error));
    const rv_solid *one[1] = {solid};
    NEED(rv_part_new(one, 1, &again, &error));
    NEED(rv_part_mesh(again, NULL, &mesh, &error));
    measured(mesh, &volume, &off);
    printf("again volume %.9f\n", volume);
    NEED(rv_part_sample(ball, plain, &few, &error));
    NEED(rv_samples_frame(few, counts, origin, &step, &error));
    NEED(rv_samples_gradients(few, &slopes, &m, &error));
    printf("step counts %zu from %.9f by %.9f gradients %zu\n", counts[0], origin[0], step, m);
    snprintf(path, sizeof path, "%s/ball.vti", folder);
    NEED(rv_samples_write(samples, path, NULL, &error));
    snprintf(path, sizeof path, "%s/ball.npy", folder);
    WRONG(rv_samples_write(samples, path, NULL, &error), RV_USAGE, "values alone");
    NEED(rv_samples_write(few, path, NULL, &error));
    WRONG(rv_samples_write(few, "a.txt", NULL, &error), RV_USAGE, "a.txt");
    memory = with("step", "0.001", "memory", "0.01");
    WRONG(rv_part_sample(ball, memory, &none, &error), RV_USAGE, "memory");
    WRONG(rv_options_set(memory, "cells", "0", &error), RV_USAGE, "cells");
    WRONG(rv_part_sample(NULL, NULL, &none, &error), RV_USAGE, "part is NULL");
    WRONG(rv_part_sample(ball, NULL, NULL, &error), RV_USAGE, "samples is NULL");
    WRONG(rv_samples_frame(NULL, counts, origin, &step, &error), RV_USAGE, "samples is NULL");
    WRONG(rv_samples_frame(few, NULL, origin, &step, &error), RV_USAGE, "counts is NULL");
    WRONG(rv_samples_frame(few, counts, NULL, &step, &error), RV_USAGE, "origin is NULL");
    WRONG(rv_samples_frame(few, counts, origin, NULL, &error), RV_USAGE, "step is NULL");
    WRONG(rv_samples_values(NULL, &values, &n, &error), RV_USAGE, "samples is NULL");
    WRONG(rv_samples_gradients(NULL, &values, &n, &error), RV_USAGE, "samples is NULL");
    WRONG(rv_samples_write(NULL, "a.vti", NULL, &error), RV_USAGE, "samples is NULL");
    rv_samples_free(samples), rv_samples_free(few), rv_samples_free(NULL), rv_solid_free(solid), rv_part_free(again), rv_mesh_free(mesh);
    rv_options_free(how), rv_options_free(plain), rv_options_free(memory);
    return 0;
}

static int outlines(const rv_part *ball, const char *folder) {
    rv_part *plate;
    rv_mesh *mesh, *round;
    const double *p;
    const uint32_t *nodes, *borders;
    const char *name;
    size_t lines, n, m, off = 0;
    char path[1000];
    NEED(rv_part_parse("part(region(rectangle(size=(4, 2)).name('plate') - circle(0.5).name('hole')))", NULL, &plate, &error));
    NEED(rv_part_mesh(plate, NULL, &mesh, &error));
    NEED(rv_mesh_points(mesh, &p, &n, &error));
    NEED(rv_mesh_contour_count(mesh, &lines, &error));
    for (size_t i = 0; i < lines; i++) {
        double area = 0;
        NEED(rv_mesh_contour(mesh, i, &nodes, &n, &error));
        NEED(rv_mesh_contour_borders(mesh, i, &borders, &m, &error));
        if (m != n) return 7;
        for (size_t k = 0; k < n; k++) {
            const double *a = p + 3 * nodes[k], *b = p + 3 * nodes[(k + 1) % n];
            area += (a[0] * b[1] - a[1] * b[0]) / 2;
            NEED(rv_mesh_border_name(mesh, borders[k], &name, &error));
            if (!strcmp(name, "plate.xmin")) off += a[0] != -2 || b[0] != -2;
            if (!strcmp(name, "hole")) off += fabs(hypot(a[0], a[1]) - 0.5) > 1e-9;
        }
        printf("contour of %s area %.9f\n", strcmp(name, "hole") ? "plate" : name, area);
    }
    NEED(rv_mesh_border_count(mesh, &m, &error));
    printf("contours %zu borders %zu off %zu\n", lines, m, off);
    snprintf(path, sizeof path, "%s/plate.svg", folder);
    NEED(rv_mesh_write(mesh, path, NULL, &error));
    NEED(rv_part_mesh(ball, NULL, &round, &error));
    NEED(rv_mesh_contour_count(round, &n, &error));
    NEED(rv_mesh_border_count(round, &m, &error));
    if (n || m) return 8;
    WRONG(rv_mesh_write(round, path, NULL, &error), RV_FAILED, "plane figures");
    WRONG(rv_mesh_contour(mesh, 2, &nodes, &n, &error), RV_USAGE, "no contour 2, only 2");
    WRONG(rv_mesh_contour_borders(round, 0, &nodes, &n, &error), RV_USAGE, "no contour 0, only 0");
    WRONG(rv_mesh_border_name(mesh, 5, &name, &error), RV_USAGE, "no border 5");
    WRONG(rv_mesh_contour_count(NULL, &n, &error), RV_USAGE, "mesh is NULL");
    WRONG(rv_mesh_contour(NULL, 0, &nodes, &n, &error), RV_USAGE, "mesh is NULL");
    WRONG(rv_mesh_contour_borders(NULL, 0, &nodes, &n, &error), RV_USAGE, "mesh is NULL");
    WRONG(rv_mesh_border_count(NULL, &n, &error), RV_USAGE, "mesh is NULL");
    WRONG(rv_mesh_border_name(NULL, 0, &name, &error), RV_USAGE, "mesh is NULL");
    rv_part_free(plate), rv_mesh_free(mesh), rv_mesh_free(round);
    return 0;
}

int main(int argc, char **argv) {
    rv_part *ball;
    if (argc != 3) return 2;
    NEED(rv_part_parse("part(sphere(1).name('ball'))", NULL, &ball, &error));
    int bad = counted(ball, argv[1]) || options_of_meshing(ball, argv[1]) || grids(ball, argv[2]) || outlines(ball, argv[2]);
    rv_part_free(ball);
    return bad;
}

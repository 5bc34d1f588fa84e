/* Pictures, curvatures, distances, what triangles are made of, and comparisons. Arguments: a file of triangles, a part file of a cube with
 * two bores, a picture to write. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "need.h"

/* Prints a text behind a word and frees it. */
static void show(const char *word, rv_text *text) {
    const char *chars = NULL;
    rv_text_chars(text, &chars, NULL);
    printf("%s 0 %s\n", word, chars ? chars : "");
    rv_text_free(text);
}

/* How many pixels of a picture are covered. */
static double covered(const rv_picture *picture) {
    const uint8_t *rgba = NULL;
    size_t width = 0, height = 0;
    double sum = 0;
    rv_picture_pixels(picture, &rgba, &width, &height, NULL);
    for (size_t i = 0; i < width * height; i++) sum += rgba[4 * i + 3] / 255.0;
    return sum;
}

static int pictures(const rv_mesh *ball, const rv_part *part, const char *file) {
    rv_options *options;
    rv_picture *picture, *half, *far;
    const uint8_t *rgba;
    size_t width, height;
    NEED(rv_options_new(&options, &error));
    NEED(rv_options_set(options, "pixels", "120x100", &error));
    NEED(rv_options_set(options, "transparent", "true", &error));
    NEED(rv_options_set(options, "legend", "false", &error));
    NEED(rv_options_set(options, "edges", "none", &error));
    NEED(rv_options_set(options, "focus", "0,0,0,4", &error));
    NEED(rv_options_set(options, "view", "front", &error));
    NEED(rv_mesh_picture(ball, NULL, options, &picture, &error));
    NEED(rv_picture_pixels(picture, &rgba, &width, &height, &error));
    NEED(rv_picture_write(picture, file, &error));
    printf("picture width %zu height %zu covered %.3f\n", width, height, covered(picture));
    WRONG(rv_picture_write(picture, "a.jpg", &error), RV_USAGE, "a.jpg");
    WRONG(rv_picture_write(picture, NULL, &error), RV_USAGE, "path is NULL");
    WRONG(rv_picture_write(NULL, file, &error), RV_USAGE, "picture is NULL");
    WRONG(rv_picture_pixels(NULL, &rgba, &width, &height, &error), RV_USAGE, "picture is NULL");
    if (rgba || width || height) return 3;
    WRONG(rv_picture_pixels(picture, NULL, &width, &height, &error), RV_USAGE, "rgba is NULL");
    WRONG(rv_mesh_picture(NULL, NULL, options, &half, &error), RV_USAGE, "mesh is NULL");
    WRONG(rv_mesh_picture(ball, NULL, options, NULL, &error), RV_USAGE, "picture is NULL");
    WRONG(rv_mesh_picture(ball, part, options, &half, &error), RV_USAGE, "color distance alone");
    WRONG(rv_options_set(options, "view", "up", &error), RV_USAGE, "up");
    WRONG(rv_options_set(options, "clips", "x=0", &error), RV_USAGE, "legend");
    NEED(rv_options_set(options, "clip", "x=0,above", &error));
    NEED(rv_mesh_picture(ball, NULL, options, &half, &error));
    printf("half covered %.3f\n", covered(half));
    NEED(rv_options_set(options, "color", "distance", &error));
    WRONG(rv_mesh_picture(ball, NULL, options, &far, &error), RV_USAGE, "surface of a part");
    NEED(rv_mesh_picture(ball, part, options, &far, &error));
    printf("far covered %.3f\n", covered(far));
    NEED(rv_options_set(options, "against", "no.py", &error));
    WRONG(rv_mesh_picture(ball, part, options, &picture, &error), RV_USAGE, "not from both");
    WRONG(rv_mesh_picture(ball, NULL, options, &picture, &error), RV_INPUT, "no.py");
    rv_picture_free(picture), rv_picture_free(half), rv_picture_free(far), rv_picture_free(NULL);
    rv_options_free(options);
    return 0;
}

static int bends(const rv_mesh *ball, const rv_part *part, const rv_options *options) {
    const double *k, *defects, *again;
    const uint8_t *classes;
    size_t n, m, corners = 0, creases = 0;
    double sum = 0, least = 9, most = 0, far = 0, distances[20000];
    rv_part *box;
    rv_mesh *cube;
    NEED(rv_mesh_curvatures(ball, &k, &n, &error));
    NEED(rv_mesh_curvatures(ball, &again, &m, &error));
    if (k != again || n != m || n > 20000) return 4;
    NEED(rv_mesh_angle_defects(ball, &defects, &m, &error));
    NEED(rv_mesh_distances(ball, part, NULL, distances, &error));
    double mean = 0;
    for (size_t i = 0; i < n; i++) {
        mean += 0.5 * (k[2 * i] + k[2 * i + 1]) / (double)n;
        least = fmin(least, k[2 * i] - k[2 * i + 1]), most = fmax(most, k[2 * i]);
        sum += defects[i];
        far = fmax(far, distances[i]);
    }
    printf("bends nodes %zu of %zu mean %.6f order %d most %.3f sum %.9f far %.3e\n", n, m, mean, least >= 0, most, sum, far);
    NEED(rv_part_parse("part(box(size=(2, 2, 2)))", NULL, &box, &error));
    NEED(rv_part_mesh(box, options, &cube, &error));
    NEED(rv_mesh_node_classes(cube, &classes, &n, &error));
    for (size_t i = 0; i < n; i++) corners += classes[i] == 2, creases += classes[i] == 1;
    printf("classes corners %zu creases %zu regular %zu\n", corners, creases, n - corners - creases);
    WRONG(rv_mesh_curvatures(NULL, &k, &n, &error), RV_USAGE, "mesh is NULL");
    if (k || n) return 5;
    WRONG(rv_mesh_angle_defects(ball, NULL, &n, &error), RV_USAGE, "array is NULL");
    WRONG(rv_mesh_node_classes(ball, &classes, NULL, &error), RV_USAGE, "count is NULL");
    WRONG(rv_mesh_distances(ball, NULL, NULL, distances, &error), RV_USAGE, "part is NULL");
    WRONG(rv_mesh_distances(ball, part, NULL, NULL, &error), RV_USAGE, "distances is NULL");
    rv_mesh_free(cube), rv_part_free(box);
    return 0;
}

static int soups(const char *file) {
    rv_text *text;
    rv_options *options;
    rv_mesh *mesh, *twice;
    rv_surface cube = {0};
    const double *k;
    size_t n;
    NEED(rv_mesh_read(file, NULL, &mesh, &error));
    NEED(rv_mesh_points(mesh, &cube.points, &cube.point_count, &error));
    NEED(rv_mesh_triangles(mesh, &cube.triangles, &cube.triangle_count, &error));
    NEED(rv_triangles_info(&cube, NULL, &text, &error));
    show("info", text);
    NEED(rv_triangles_info_file(file, NULL, &text, &error));
    show("info_file", text);
    NEED(rv_options_new(&options, &error));
    NEED(rv_options_set(options, "size", "0.5", &error));
    NEED(rv_compare_triangles(&cube, options, &text, &error));
    show("soup", text);
    NEED(rv_compare_triangles_file(file, options, &text, &error));
    show("soup_file", text);
    NEED(rv_options_set(options, "size", "0.4", &error));
    NEED(rv_compare_samples(options, &text, &error));
    show("samples", text);
    NEED(rv_options_set(options, "without", "trim", &error));
    WRONG(rv_compare_triangles(&cube, options, &text, &error), RV_USAGE, "neither volume");
    WRONG(rv_compare_samples(options, &text, &error), RV_USAGE, "neither volume");
    WRONG(rv_compare_samples(options, NULL, &error), RV_USAGE, "report is NULL");
    WRONG(rv_triangles_info(NULL, NULL, &text, &error), RV_USAGE, "surface is NULL");
    WRONG(rv_triangles_info_file(NULL, NULL, &text, &error), RV_USAGE, "path is NULL");
    WRONG(rv_triangles_info_file("no.stl", NULL, &text, &error), RV_INPUT, "no.stl");
    WRONG(rv_triangles_info(&cube, NULL, NULL, &error), RV_USAGE, "report is NULL");
    WRONG(rv_compare_triangles_file("no.stl", NULL, &text, &error), RV_INPUT, "no.stl");
    if (text) return 6;
    /* A mesh joined to itself has every edge in the same direction twice. */
    const rv_mesh *both[2] = {mesh, mesh};
    if (rv_mesh_join(both, 2, NULL, &twice, &error) > RV_SHORT) return 7;
    WRONG(rv_mesh_curvatures(twice, &k, &n, &error), RV_INPUT, "");
    rv_mesh_free(mesh), rv_mesh_free(twice), rv_options_free(options);
    return 0;
}

int main(int argc, char **argv) {
    rv_part *part, *bored;
    rv_options *options;
    rv_mesh *ball;
    rv_text *text;
    int failed;
    if (argc != 4) return 2;
    NEED(rv_options_new(&options, &error));
    NEED(rv_options_set(options, "size", "0.3", &error));
    NEED(rv_part_parse("part(sphere(2).name('ball'))", NULL, &part, &error));
    NEED(rv_part_mesh(part, options, &ball, &error));
    failed = pictures(ball, part, argv[3]);
    if (!failed) failed = bends(ball, part, options);
    if (!failed) failed = soups(argv[1]);
    if (failed) return failed;
    NEED(rv_part_load(argv[2], NULL, &bored, &error));
    NEED(rv_compare_rsystems(bored, options, &text, &error));
    show("rsystems", text);
    WRONG(rv_compare_rsystems(NULL, options, &text, &error), RV_USAGE, "part is NULL");
    rv_part_free(part), rv_part_free(bored), rv_mesh_free(ball), rv_options_free(options);
    return 0;
}

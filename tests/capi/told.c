/* Faces that decide at points, pictures of comparisons, and what is told of parts built from edges. Arguments: a file of triangles, and
 * pictures to write of a part, of triangles, and of the samples. */

#include <stdio.h>
#include <string.h>

#include "need.h"

static int faces(const rv_part *part) {
    /* Near the middles of two sides, in the bore, beyond the roof, and on the floor. */
    const double at[15] = {-0.95, 0.6, 0.5, 0.1, 0.97, 0.2, 0.1, 0, 0, 0.7, 0.6, 1.5, 0.8, 0.7, -1};
    int32_t found[5];
    size_t count;
    rv_text *name;
    const char *chars;
    NEED(rv_part_faces(part, 5, at, found, &error));
    NEED(rv_part_face_count(part, &count, &error));
    if (count != 7) return 3;
    for (int i = 0; i < 5; i++) {
        NEED(rv_part_face_name(part, (size_t)found[i], &name, &error));
        NEED(rv_text_chars(name, &chars, &error));
        printf("%sat %s", i ? " " : "faces 7\n", chars);
        rv_text_free(name);
    }
    printf("\n");
    NEED(rv_part_faces(part, 0, NULL, NULL, &error));
    WRONG(rv_part_face_name(part, 7, &name, &error), RV_USAGE, "no face 7 of 7");
    WRONG(rv_part_face_name(part, 0, NULL, &error), RV_USAGE, "name is NULL");
    WRONG(rv_part_face_count(part, NULL, &error), RV_USAGE, "count is NULL");
    WRONG(rv_part_faces(part, 5, at, NULL, &error), RV_USAGE, "faces is NULL");
    WRONG(rv_part_faces(part, 5, NULL, found, &error), RV_USAGE, "xyz is NULL");
    WRONG(rv_part_faces(NULL, 5, at, found, &error), RV_USAGE, "part is NULL");
    return 0;
}

static int pictures(const rv_part *part, char **files) {
    rv_options *options;
    rv_text *text;
    NEED(rv_options_new(&options, &error));
    NEED(rv_options_set(options, "size", "0.4", &error));
    NEED(rv_options_set(options, "png", "c.jpg", &error));
    WRONG(rv_compare(part, options, &text, &error), RV_USAGE, "c.jpg");
    NEED(rv_options_set(options, "png", files[1], &error));
    WRONG(rv_compare_rsystems(part, options, &text, &error), RV_USAGE, "no picture");
    NEED(rv_compare(part, options, &text, &error));
    rv_text_free(text);
    NEED(rv_options_set(options, "png", files[3], &error));
    NEED(rv_compare_samples(options, &text, &error));
    rv_text_free(text);
    NEED(rv_options_set(options, "color", "face", &error));
    WRONG(rv_compare_samples(options, &text, &error), RV_USAGE, "angle or class");
    NEED(rv_options_set(options, "color", "class", &error));
    NEED(rv_options_set(options, "png", files[2], &error));
    NEED(rv_compare_triangles_file(files[0], options, &text, &error));
    rv_text_free(text), rv_options_free(options);
    return 0;
}

int main(int argc, char **argv) {
    rv_part *part, *bar;
    rv_text *text;
    const char *chars;
    int32_t face;
    if (argc != 5) return 2;
    NEED(rv_part_parse("part(box(size=(2, 2, 2)).name('body') - cylinder(0.4, axis='x').name('bore'))", NULL, &part, &error));
    int failed = faces(part);
    if (!failed) failed = pictures(part, argv + 1);
    if (failed) return failed;
    NEED(rv_part_parse("units('mm')\n"
                       "part(extrude_edges([polyline([(0, 0), (2, 0), (2, 2), (0, 2)], closed=True)], 'z', 2).name('bar'))",
                       NULL, &bar, &error));
    NEED(rv_part_info(bar, &text, &error));
    NEED(rv_text_chars(text, &chars, &error));
    printf("bar 0 %s\n", chars);
    /* Of what is built from edges it is the distance to the boundary. */
    const double within[3] = {1, 1, 0.25};
    double value;
    NEED(rv_part_values(bar, 1, within, &value, &error));
    NEED(rv_part_faces(bar, 1, within, &face, &error));
    if (value != 0.25 || face < 0) return 1;
    rv_text_free(text), rv_part_free(bar), rv_part_free(part);
    return 0;
}

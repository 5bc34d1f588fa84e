/* Units, one face made anew, and prisms: of a block of 2 by 2 by 1, and of a cube in the file that is the first argument. The
 * second is a folder for files. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "need.h"

/* Triangles of a face, and how many of the others are in the same places in the same order. */
static size_t same(const rv_mesh *a, const rv_mesh *b, uint32_t but) {
    const double *p[2];
    const uint32_t *t[2], *faces[2];
    size_t n, m[2], at[2] = {0, 0}, found = 0;
    const rv_mesh *both[2] = {a, b};
    for (int i = 0; i < 2; i++) {
        rv_mesh_points(both[i], &p[i], &n, NULL), rv_mesh_triangles(both[i], &t[i], &m[i], NULL);
        rv_mesh_labels(both[i], &faces[i], &n, NULL);
    }
    for (;; at[0]++, at[1]++, found++) {
        for (int i = 0; i < 2; i++)
            while (at[i] < m[i] && faces[i][at[i]] == but) at[i]++;
        if (at[0] == m[0] || at[1] == m[1]) return at[0] == m[0] && at[1] == m[1] ? found : 0;
        for (int k = 0; k < 3; k++)
            if (memcmp(p[0] + 3 * t[0][3 * at[0] + k], p[1] + 3 * t[1][3 * at[1] + k], 3 * sizeof(double))) return 0;
    }
}

int main(int argc, char **argv) {
    rv_part *part;
    rv_options *options;
    rv_mesh *mesh, *fine, *cube, *none;
    rv_prisms *prisms, *between;
    const char *units, *name;
    const double *p, up[3] = {0, 0, 3};
    const uint32_t *cells, *sides, *labels, *t;
    size_t n, m, k, coarse, finer;
    double volume, area = 0;
    char path[1000];
    if (argc != 3) return 2;

    NEED(rv_part_parse("part(box(lo=(0, 0, 0), hi=(2, 2, 1)).name(\"b\"))", NULL, &part, &error));
    NEED(rv_part_units(part, &units, &error));
    if (units) return 3;
    NEED(rv_part_set_units(part, "mm", &error));
    NEED(rv_part_units(part, &units, &error));
    if (strcmp(units, "mm")) return 4;
    WRONG(rv_part_units(NULL, &units, &error), RV_USAGE, "part is NULL");
    WRONG(rv_mesh_units(NULL, &units, &error), RV_USAGE, "mesh is NULL");

    NEED(rv_options_new(&options, &error));
    WRONG(rv_mesh_remesh_face(NULL, "b.zmax", NULL, &fine, &error), RV_USAGE, "mesh is NULL");
    NEED(rv_options_set(options, "size", "0.4", &error));
    NEED(rv_part_mesh(part, options, &mesh, &error));
    NEED(rv_mesh_units(mesh, &units, &error));
    printf("units %s\n", units);
    snprintf(path, sizeof path, "%s/block.3mf", argv[2]);
    NEED(rv_mesh_write(mesh, path, NULL, &error));

    WRONG(rv_mesh_remesh_face(mesh, "b.zmax", NULL, &fine, &error), RV_USAGE, "size");
    WRONG(rv_mesh_remesh_face(mesh, "b", options, &fine, &error), RV_USAGE, "b.zmax");
    WRONG(rv_mesh_remesh_face(mesh, NULL, options, &fine, &error), RV_USAGE, "face is NULL");
    NEED(rv_options_set(options, "size", "0.1", &error));
    NEED(rv_mesh_remesh_face(mesh, "b.zmax", options, &fine, &error));
    NEED(rv_mesh_triangles_of(mesh, "b.zmax", &t, &coarse, &error));
    NEED(rv_mesh_triangles_of(fine, "b.zmax", &t, &finer, &error));
    NEED(rv_mesh_labels(mesh, &labels, &m, &error));
    NEED(rv_mesh_triangles_of(mesh, "b.zmax", &t, &coarse, &error));
    printf("face before %zu after %zu others %zu same %zu\n", coarse, finer, m - coarse, same(mesh, fine, labels[t[0]]));
    NEED(rv_mesh_read(argv[1], NULL, &cube, &error));
    WRONG(rv_mesh_remesh_face(cube, "floor", options, &none, &error), RV_INPUT, "solid");

    rv_text *page;
    const char *html;
    WRONG(rv_mesh_page(NULL, "a", &page, &error), RV_USAGE, "mesh is NULL");
    WRONG(rv_mesh_page(mesh, NULL, &page, &error), RV_USAGE, "title is NULL");
    NEED(rv_mesh_page(mesh, "<b>block</b>", &page, &error));
    NEED(rv_text_chars(page, &html, &error));
    printf("page %d\n", strstr(html, "<b>block</b>") == NULL && strstr(html, "b.zmax") != NULL);
    rv_text_free(page);
    const char *formats[] = {"vm", "3mf"};
    for (int i = 0; i < 2; i++) {
        rv_part *again;
        double at[6] = {1, 1, 0.25, 1, 1, 1.5}, values[2];
        snprintf(path, sizeof path, "%s/part.%s", argv[2], formats[i]);
        NEED(rv_part_write(part, path, &error));
        NEED(rv_part_load(path, NULL, &again, &error));
        NEED(rv_part_values(again, 2, at, values, &error));
        printf("written %s inside %d outside %d\n", formats[i], values[0] > 0, values[1] < 0);
        rv_part_free(again);
    }
    WRONG(rv_part_write(NULL, path, &error), RV_USAGE, "part is NULL");
    WRONG(rv_part_write(part, NULL, &error), RV_USAGE, "path is NULL");
    WRONG(rv_part_write(part, "a.docx", &error), RV_USAGE, "a.docx");
    WRONG(rv_part_write(part, "a.step", &error), RV_INPUT, "edges");

    /* Away from the block. */
    rv_sweep sweep = {.face = "b.zmax", .along = up, .layers = 4};
    NEED(rv_mesh_sweep(mesh, &sweep, &prisms, &error));
    NEED(rv_prisms_points(prisms, &p, &n, &error));
    NEED(rv_prisms_cells(prisms, &cells, &m, &error));
    NEED(rv_prisms_sides(prisms, &sides, &k, &error));
    NEED(rv_prisms_labels(prisms, &labels, &k, &error));
    NEED(rv_prisms_volume(prisms, &volume, &error));
    for (size_t i = 0; i < k; i++) { /* the area of the roof */
        NEED(rv_prisms_name(prisms, labels[i], &name, &error));
        if (strcmp(name, "opposite")) continue;
        const double *a = p + 3 * sides[4 * i], *b = p + 3 * sides[4 * i + 1], *c = p + 3 * sides[4 * i + 2];
        if (a[2] != 4 || sides[4 * i + 2] != sides[4 * i + 3]) return 5;
        area += ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
    }
    NEED(rv_prisms_name_count(prisms, &k, &error));
    printf("swept cells %zu of %zu volume %.9f roof %.9f names %zu\n", m, coarse, volume, area, k);
    WRONG(rv_prisms_name(prisms, k, &name, &error), RV_USAGE, "no name");
    snprintf(path, sizeof path, "%s/block.msh", argv[2]);
    NEED(rv_prisms_write(prisms, path, NULL, &error));
    snprintf(path, sizeof path, "%s/block.stl", argv[2]);
    WRONG(rv_prisms_write(prisms, path, NULL, &error), RV_USAGE, "vtu, msh or inp");

    /* A point is told where linear values are what they are there; a way over an edge is that of the net. */
    double linear[5000], at[6] = {0.3, 0.7, 1, 1, 1, 3}, carried[4], away[2], from[3] = {1.5, 0.5, 1}, to[3] = {2, 1.5, 0.5}, length;
    rv_path *way;
    NEED(rv_mesh_points(mesh, &p, &n, &error));
    if (2 * n > 5000) return 7;
    for (size_t i = 0; i < n; i++) linear[2 * i] = p[3 * i] + 2 * p[3 * i + 1], linear[2 * i + 1] = p[3 * i + 2];
    rv_carry carry = {.values = linear, .width = 2, .xyz = at, .count = 2, .carried = carried, .distances = away};
    NEED(rv_mesh_carry(mesh, &carry, &error));
    printf("carried a %.9f b %.9f c %.9f d %.9f near %.9f far %.9f\n", carried[0], carried[1], carried[2], carried[3], away[0], away[1]);
    carry.distances = NULL;
    NEED(rv_mesh_carry(mesh, &carry, &error));
    WRONG(rv_mesh_carry(NULL, &carry, &error), RV_USAGE, "mesh is NULL");
    WRONG(rv_mesh_carry(mesh, NULL, &error), RV_USAGE, "what is NULL");
    carry.width = (size_t)-1;
    WRONG(rv_mesh_carry(mesh, &carry, &error), RV_USAGE, "items");
    carry.width = 2, carry.carried = NULL;
    WRONG(rv_mesh_carry(mesh, &carry, &error), RV_USAGE, "carried is NULL");
    carry.carried = carried, carry.values = NULL;
    WRONG(rv_mesh_carry(mesh, &carry, &error), RV_USAGE, "values is NULL");
    carry.values = linear, at[0] = NAN;
    WRONG(rv_mesh_carry(mesh, &carry, &error), RV_INPUT, "");
    NEED(rv_mesh_path(mesh, from, to, &way, &error));
    NEED(rv_path_points(way, &p, &n, &error));
    NEED(rv_path_length(way, &length, &error));
    printf("way length %.9f ends %.9f %.9f\n", length, p[0], p[3 * n - 1]);
    rv_path_free(way), rv_path_free(NULL);
    WRONG(rv_mesh_path(mesh, from, NULL, &way, &error), RV_USAGE, "to is NULL");
    WRONG(rv_mesh_path(NULL, from, to, &way, &error), RV_USAGE, "mesh is NULL");
    WRONG(rv_path_points(NULL, &p, &n, &error), RV_USAGE, "path is NULL");
    WRONG(rv_path_length(NULL, &length, &error), RV_USAGE, "path is NULL");

    /* Two blocks a hundredth of their size apart have no node in common, and become one within a length. */
    rv_part *beside;
    rv_mesh *next, *joined;
    rv_options *wide;
    const char *text;
    NEED(rv_part_parse("part(box(lo=(0, 0, 1.01), hi=(2, 2, 2.01)).name(\"c\"))", NULL, &beside, &error));
    NEED(rv_options_new(&wide, &error));
    NEED(rv_options_set(wide, "size", "0.4", &error));
    NEED(rv_part_mesh(beside, wide, &next, &error));
    const rv_mesh *both[2] = {mesh, next}, *twin[2] = {mesh, mesh}, *hollow[2] = {mesh, NULL};
    if (rv_mesh_join(both, 2, NULL, &joined, &error) != RV_SHORT) return 9;
    NEED(rv_mesh_shortfall(joined, 1, &text, &error));
    NEED(rv_mesh_points(joined, &p, &k, &error));
    NEED(rv_mesh_points(next, &p, &m, &error));
    NEED(rv_mesh_points(mesh, &p, &n, &error));
    printf("apart %d %s\n", k == n + m, text);
    rv_mesh_free(joined);
    NEED(rv_options_set(wide, "within", "0.02", &error));
    NEED(rv_mesh_join(both, 2, wide, &joined, &error));
    NEED(rv_mesh_points(joined, &p, &k, &error));
    NEED(rv_mesh_face_count(joined, &finer, &error));
    NEED(rv_mesh_report(joined, &text, &error));
    printf("joined fewer %d faces %zu report %d\n", k < n + m, finer, strstr(text, "\"matched\"") != NULL);
    rv_mesh_free(joined);
    NEED(rv_mesh_join(twin, 2, NULL, &joined, &error));
    NEED(rv_mesh_points(joined, &p, &k, &error));
    NEED(rv_mesh_triangles(joined, &t, &m, &error));
    NEED(rv_mesh_triangles(mesh, &t, &coarse, &error));
    printf("twin %d %d\n", k == n, m == 2 * coarse);
    rv_mesh_free(joined);
    WRONG(rv_mesh_join(both, 0, NULL, &joined, &error), RV_USAGE, "");
    WRONG(rv_mesh_join(NULL, 2, NULL, &joined, &error), RV_USAGE, "meshes is NULL");
    WRONG(rv_mesh_join(hollow, 2, NULL, &joined, &error), RV_USAGE, "a mesh is NULL");
    WRONG(rv_options_set(wide, "within", "-1", &error), RV_USAGE, "");
    rv_mesh_free(next), rv_part_free(beside), rv_options_free(wide);

    NEED(rv_mesh_triangles_of(mesh, "b.zmax", &t, &coarse, &error));
    rv_prisms *paired, *twice;
    NEED(rv_prisms_hexahedra(prisms, &cells, &n, &error));
    if (n) return 8;
    NEED(rv_prisms_pair(prisms, 45, &paired, &error));
    NEED(rv_prisms_hexahedra(paired, &cells, &n, &error));
    NEED(rv_prisms_cells(paired, &cells, &k, &error));
    NEED(rv_prisms_volume(paired, &volume, &error));
    NEED(rv_prisms_name(paired, 1, &name, &error));
    printf("paired hexahedra %zu prisms %zu volume %.9f top %s\n", n, k, volume, name);
    snprintf(path, sizeof path, "%s/block.inp", argv[2]);
    NEED(rv_prisms_write(paired, path, NULL, &error));
    WRONG(rv_prisms_pair(NULL, 45, &twice, &error), RV_USAGE, "prisms is NULL");
    WRONG(rv_prisms_pair(prisms, NAN, &twice, &error), RV_USAGE, "off");
    WRONG(rv_prisms_pair(paired, 45, &twice, &error), RV_USAGE, "partner");
    WRONG(rv_prisms_hexahedra(NULL, &cells, &n, &error), RV_USAGE, "prisms is NULL");
    rv_prisms_free(paired);

    sweep = (rv_sweep){.face = "floor", .to = "roof", .layers = 3};
    NEED(rv_mesh_sweep(cube, &sweep, &between, &error));
    NEED(rv_prisms_cells(between, &cells, &m, &error));
    NEED(rv_prisms_volume(between, &volume, &error));
    printf("between cells %zu volume %.9f\n", m, volume);

    rv_prisms *other;
    WRONG(rv_mesh_sweep(NULL, &sweep, &other, &error), RV_USAGE, "mesh is NULL");
    WRONG(rv_mesh_sweep(cube, NULL, &other, &error), RV_USAGE, "sweep is NULL");
    sweep.along = up;
    WRONG(rv_mesh_sweep(cube, &sweep, &other, &error), RV_USAGE, "one of the two");
    sweep.along = NULL, sweep.layers = 0;
    WRONG(rv_mesh_sweep(cube, &sweep, &other, &error), RV_USAGE, "layer");
    sweep.to = "wall", sweep.layers = 1;
    WRONG(rv_mesh_sweep(cube, &sweep, &other, &error), RV_INPUT, "");
    if (other) return 6;
    WRONG(rv_prisms_points(NULL, &p, &n, &error), RV_USAGE, "prisms is NULL");
    WRONG(rv_prisms_cells(NULL, &cells, &n, &error), RV_USAGE, "prisms is NULL");
    WRONG(rv_prisms_sides(NULL, &cells, &n, &error), RV_USAGE, "prisms is NULL");
    WRONG(rv_prisms_labels(NULL, &cells, &n, &error), RV_USAGE, "prisms is NULL");
    WRONG(rv_prisms_name_count(NULL, &n, &error), RV_USAGE, "prisms is NULL");
    WRONG(rv_prisms_name(NULL, 0, &name, &error), RV_USAGE, "prisms is NULL");
    WRONG(rv_prisms_volume(NULL, &volume, &error), RV_USAGE, "prisms is NULL");
    WRONG(rv_prisms_write(NULL, path, NULL, &error), RV_USAGE, "prisms is NULL");

    rv_prisms_free(prisms), rv_prisms_free(between), rv_prisms_free(NULL);
    rv_mesh_free(mesh), rv_mesh_free(fine), rv_mesh_free(cube), rv_options_free(options), rv_part_free(part);
    return 0;
}

/* rvachev.h: solids to triangle meshes, from C. docs/calling.md has programs that use it. C99; from C++ see rvachev.hpp.
 *
 * Status. Calls return one of the codes below: those of the command, and RV_STOPPED. Calls that return nothing cannot fail.
 *
 * Errors. The last argument of each call that can fail is a place for an error. It may be NULL. It is always written: NULL where the
 * call was good or short, else a handle to read and to free by rv_error_free. Outputs of a call that failed are NULL or 0.
 *
 * Ownership. What a call named ..._new, _parse, _load, _mesh and so on puts into a `handle **` is the caller's, to be freed once by
 * the handle's own ..._free; NULL may be freed. Handles keep what they need: a solid may be freed when a part was made of it, a part
 * when it is meshed. Arrays and texts that come out as pointers to const are lent: they live, unchanged, as long as the handle they
 * were asked of. Arrays and texts that go in are read during the call only.
 *
 * Threads. Any handle may be used by several threads at once; only freeing is for one, when no other uses it. Long calls work with
 * threads of their own (option "threads"), which are gone when they return. Results are the same for any number of threads. Nothing
 * is global, and nothing is printed.
 *
 * Numbers. Coordinates are double, x y z for each point, in the part's unit. Nodes and triangles are uint32_t, from 0. Texts are
 * UTF-8, ended by a zero. Inside is where functions are positive; triangles are counter-clockwise seen from outside. */

#ifndef RVACHEV_H
#define RVACHEV_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    RV_GOOD = 0,       /* done */
    RV_SHORT = 1,      /* made, but it falls short of what was asked: rv_mesh_shortfall says how */
    RV_USAGE = 2,      /* the request makes no sense: NULL, an unknown option, a negative size */
    RV_INPUT = 3,      /* the input cannot be used as it is */
    RV_FAILED = 4,     /* the input is good, but what was asked was not reached */
    RV_STOPPED = 5,    /* a field's function stopped the run: rv_error_user_code has what it returned */
    RV_CANCELLED = 130 /* rv_run_cancel was called */
};

typedef struct rv_error rv_error;
typedef struct rv_options rv_options;
typedef struct rv_run rv_run;
typedef struct rv_solid rv_solid;
typedef struct rv_part rv_part;
typedef struct rv_mesh rv_mesh;
typedef struct rv_prisms rv_prisms;
typedef struct rv_path rv_path;
typedef struct rv_samples rv_samples;
typedef struct rv_picture rv_picture;
typedef struct rv_text rv_text;

/* The version of the library, such as "0.1.0". */
const char *rv_version(void);

/* ------------------------------------------------------------------------------------------------------------ errors */

/* The status the call returned; RV_GOOD for NULL. */
int rv_error_status(const rv_error *error);
/* What went wrong, in one sentence, with its place; "" for NULL. */
const char *rv_error_message(const rv_error *error);
/* What would be right; NULL where that is not known. */
const char *rv_error_help(const rv_error *error);
/* The file; NULL where there is none. */
const char *rv_error_file(const rv_error *error);
/* The line and the column (in characters), from 1; 0 where none is known. */
size_t rv_error_line(const rv_error *error);
size_t rv_error_column(const rv_error *error);
/* For RV_STOPPED what the field's function returned, and the field's `user`. */
int rv_error_user_code(const rv_error *error);
void *rv_error_user(const rv_error *error);
void rv_error_free(rv_error *error);

/* ----------------------------------------------------------------------------------------------------------- options */

int rv_options_new(rv_options **options, rv_error **error);

/* Options have the names and values of the command: size ("2%" of the diagonal, or a length), method, sequence (of operators, which
 * stands for the method that runs it), angle, tol and size-min (lengths, or "0.1%" of the diagonal), volume (a share), grading, trim,
 * thickness, refine and without (a remedy left out; both may be said often), eps, memory (GiB); for triangles feature-angle, min-area,
 * min-length, nodes, close; for healing max-hole; for grids cells, step, margin, gradient; for meshes to be joined within; for files
 * groups ("user", "faces", "all"), msh-version; for pictures view, focus, clip, color, edges, pixels, transparent, legend, against, which
 * rv_mesh_picture describes; for comparisons png (a file) and color; and threads (0: all), force ("true" gives meshes that are not sound),
 * measure ("false" measures only what makes a mesh sound), define ("radius=0.3", may be said often).
 * Wherever options are asked for NULL stands for none. */
int rv_options_set(rv_options *options, const char *name, const char *value, rv_error **error);

/* Calls with these options are cancelled and watched through `run`; not at all for NULL. */
int rv_options_set_run(rv_options *options, const rv_run *run, rv_error **error);
void rv_options_free(rv_options *options);

/* A run is made before a call, given to it by its options, and used from any other thread meanwhile. One that was cancelled, or
 * that a field's function stopped, stays so: make another one for the next call. */
int rv_run_new(rv_run **run, rv_error **error);
int rv_run_cancel(const rv_run *run, rv_error **error);
/* Copies the name of the stage into `stage`, which has room for `capacity` bytes, and the share of it that is done, 0 to 1. */
int rv_run_progress(const rv_run *run, char *stage, size_t capacity, double *done, rv_error **error);
void rv_run_free(rv_run *run);

/* ------------------------------------------------------------------------------------------------------------ solids */

/* A solid as part files have it, built from edges or not: "box(size=(2, 2, 2)) - cylinder(0.4)", "solid(x**2 + y**2 <= z)". */
int rv_solid_parse(const char *text, rv_solid **solid, rv_error **error);

/* Points and directions are three numbers. `at` may be NULL for the origin, the torus's `axis` for z. */
int rv_solid_box(const double *lo, const double *hi, rv_solid **solid, rv_error **error);
int rv_solid_sphere(double radius, const double *at, rv_solid **solid, rv_error **error);
int rv_solid_cylinder(double radius, const double *from, const double *to, rv_solid **solid, rv_error **error);
int rv_solid_cone(const double *radii, const double *from, const double *to, rv_solid **solid, rv_error **error);
int rv_solid_torus(const double *radii, const double *axis, const double *at, rv_solid **solid, rv_error **error);
/* The side the normal points away from. */
int rv_solid_half_space(const double *normal, const double *at, rv_solid **solid, rv_error **error);

/* Set operations give a new solid and leave the old ones as they are. */
int rv_solid_union(const rv_solid *const *solids, size_t count, rv_solid **solid, rv_error **error);
int rv_solid_intersection(const rv_solid *const *solids, size_t count, rv_solid **solid, rv_error **error);
int rv_solid_difference(const rv_solid *a, const rv_solid *b, rv_solid **solid, rv_error **error);
int rv_solid_complement(const rv_solid *a, rv_solid **solid, rv_error **error);
int rv_solid_blend(const rv_solid *a, const rv_solid *b, double radius, rv_solid **solid, rv_error **error);

/* Placements, names of faces and wishes for edges of a length, as the methods of part files; they, too, give a new solid. */
int rv_solid_move(const rv_solid *a, const double *by, rv_solid **solid, rv_error **error);
int rv_solid_rotate(const rv_solid *a, double degrees, const double *axis, rv_solid **solid, rv_error **error);
int rv_solid_scale(const rv_solid *a, double factor, rv_solid **solid, rv_error **error);
int rv_solid_name(const rv_solid *a, const char *name, rv_solid **solid, rv_error **error);
int rv_solid_size(const rv_solid *a, double length, rv_solid **solid, rv_error **error);
/* Any of these, or a chain, as text: "rotate(90, axis=\"x\", at=(1, 0, 0)).mirror(\"z\").name(\"arm\")". */
int rv_solid_apply(const rv_solid *a, const char *methods, rv_solid **solid, rv_error **error);
void rv_solid_free(rv_solid *solid);

/* A function: `n` points in `xyz`, writes n values, positive inside, best about the distance near the surface, and, unless
 * `gradient` is NULL, three numbers of the gradient for each point. The same points must give the same values. Whatever it returns
 * but 0 stops the run: the call returns RV_STOPPED, the code is rv_error_user_code. It must not leave by longjmp or an exception. */
typedef int (*rv_function)(size_t n, const double *xyz, double *value, double *gradient, void *user);
typedef void (*rv_release)(void *user);

/* What is not said is 0: rv_field f = {.function = mine, .user = &data}; */
typedef struct rv_field {
    rv_function function;
    void *user;           /* handed to the function */
    rv_release release;   /* called once with `user`, from any thread, when nothing holds the field any more; may be NULL */
    double lipschitz;     /* values change by at most this much per length: regions are skipped; 0: not known, all cells are asked */
    const double *bounds; /* x0 y0 z0 x1 y1 z1: called inside only, and the solid is cut off there; NULL: everywhere */
    int has_gradient;     /* whether it can give gradients; if not, `gradient` is always NULL */
    int concurrent;       /* 0: called by one thread at a time (not always the same); else by several at once. A function that is
                             called by one at a time must not mesh or evaluate its own field. */
} rv_field;

/* If the call fails, `release` is not called. */
int rv_solid_field(const rv_field *field, rv_solid **solid, rv_error **error);

/* Values on a grid of counts[0] * counts[1] * counts[2] points, x running fastest, from corner to corner of `bounds` (as above),
 * trilinear between them; cut off at the bounds. The values are copied. */
int rv_solid_grid(const size_t *counts, const double *bounds, const double *values, rv_solid **solid, rv_error **error);

/* ------------------------------------------------------------------------------------------------------------- parts */

/* Of the options `define` is heeded. */
int rv_part_parse(const char *source, const rv_options *options, rv_part **part, rv_error **error);
int rv_part_load(const char *path, const rv_options *options, rv_part **part, rv_error **error);
/* One solid of R-functions at most, and any number of solids built from edges. */
int rv_part_new(const rv_solid *const *solids, size_t count, rv_part **part, rv_error **error);
/* "m", "dm", "cm", "mm", "um", "in" or "ft"; only files are told. */
int rv_part_set_units(rv_part *part, const char *units, rv_error **error);
/* The unit, which lives as long as the library; NULL where none was said. */
int rv_part_units(const rv_part *part, const char **units, rv_error **error);
/* "R0", "minmax", "(\"Ralpha\", 0.5)" or "(\"R0m\", 2)". */
int rv_part_set_rsystem(rv_part *part, const char *rsystem, rv_error **error);
/* x0 y0 z0 x1 y1 z1: where to cut off what may be infinite; NULL for nowhere. */
int rv_part_set_domain(rv_part *part, const double *bounds, rv_error **error);
/* Adds faces to a group, by a pattern of names ("*" any characters, "?" one); may be said often. */
int rv_part_group(rv_part *part, const char *name, const char *faces, rv_error **error);
/* What is known before meshing, as JSON of `rvachev info --json`: surfaces, a box around the part, names of faces and groups; of solids built
 * from edges numbers of vertices and edges, a box, bodies with volumes, faces with areas. With both, these are the member "built". */
int rv_part_info(const rv_part *part, rv_text **info, rv_error **error);
/* The part's function at points: positive inside, about the distance near the surface. Room for `count` values. */
int rv_part_values(const rv_part *part, size_t count, const double *xyz, double *values, rv_error **error);
/* Its gradient, which points inwards. Room for 3 * `count` numbers. */
int rv_part_gradients(const rv_part *part, size_t count, const double *xyz, double *gradients, rv_error **error);
/* The face at points, a number from 0 of each: the one whose leaf decides min / max of all leaves, on the boundary the one the point is on;
 * -1 where none decides, without meaning where the value is NaN. Room for `count` numbers, which fit the names below. */
int rv_part_faces(const rv_part *part, size_t count, const double *xyz, int32_t *faces, rv_error **error);
int rv_part_face_count(const rv_part *part, size_t *count, rv_error **error);
int rv_part_face_name(const rv_part *part, size_t index, rv_text **name, rv_error **error);
int rv_part_mesh(const rv_part *part, const rv_options *options, rv_mesh **mesh, rv_error **error);
/* About how many triangles that mesh will have, within a tenth as a rule: told once lengths of edges are known, and no mesh is made. */
int rv_expected_triangles(const rv_part *part, const rv_options *options, size_t *count, rv_error **error);
/* Solids built from edges only. */
int rv_part_write_step(const rv_part *part, const char *path, rv_error **error);
/* By extension: step or stp for solids built from edges; vm (a formula file) or 3mf (a level set) for one of R-functions. */
int rv_part_write(const rv_part *part, const char *path, rv_error **error);
void rv_part_free(rv_part *part);

/* ------------------------------------------------------------------------------------------------------------- grids */

/* The part's function on a regular grid over its box and the option "margin" around it (a length or a share of the diagonal, 5% unless
 * said otherwise). The option "cells" is the number of cells along the longest side (64), "step" their width instead; "gradient" is
 * "true" for gradients too. RV_SHORT where a number is not finite; RV_USAGE for more than the option "memory" allows, before any work. */
int rv_part_sample(const rv_part *part, const rv_options *options, rv_samples **samples, rv_error **error);
/* Room for three counts and three numbers: point i j k is at origin + step * (i, j, k). */
int rv_samples_frame(const rv_samples *samples, size_t *counts, double *origin, double *step, rv_error **error);
/* Lent, x running fastest, then y, as rv_solid_grid takes them. */
int rv_samples_values(const rv_samples *samples, const double **values, size_t *count, rv_error **error);
/* Three numbers of each point; `count` is 0 where gradients were not asked for. */
int rv_samples_gradients(const rv_samples *samples, const double **xyz, size_t *count, rv_error **error);
/* By extension: vti; npy for values alone, as float64 of shape nz, ny, nx. */
int rv_samples_write(const rv_samples *samples, const char *path, const rv_options *options, rv_error **error);
void rv_samples_free(rv_samples *samples);

/* ------------------------------------------------------------------------------------- meshes from files and triangles */

/* Meshes a part file, a STEP file, or a file of triangles, anew. */
int rv_mesh_file(const char *path, const rv_options *options, rv_mesh **mesh, rv_error **error);
/* About how many triangles that mesh will have. */
int rv_expected_triangles_file(const char *path, const rv_options *options, size_t *count, rv_error **error);
/* What is wrong with the model of a STEP file, as JSON of `rvachev check --json`; RV_SHORT where anything is. */
int rv_step_check(const char *path, const rv_options *options, rv_text **report, rv_error **error);
/* What is in it, as JSON of `rvachev info --json`: bodies with volumes, faces with areas, a box. Lengths are in millimeters. RV_SHORT where
 * something was not understood or had to be put right, which the notes tell. */
int rv_step_info(const char *path, const rv_options *options, rv_text **info, rv_error **error);
/* Every stage of every method measured on a part, as JSON of `rvachev compare --json`. The options volume and without are
 * wrong here. The option png names a file for the picture of all stages, as `--png` does; its color is "angle" or "class". */
int rv_compare(const rv_part *part, const rv_options *options, rv_text **report, rv_error **error);
/* R-systems instead of methods: how near the part's function is to a distance under each, as JSON of `rvachev compare --rsystems
 * --json`. There is no picture of it: the option png is wrong here. */
int rv_compare_rsystems(const rv_part *part, const rv_options *options, rv_text **report, rv_error **error);
/* Every method measured on three cubes with two holes that come with the library, as JSON of `rvachev compare --samples --json`.
 * The options png and color are those of rv_compare. */
int rv_compare_samples(const rv_options *options, rv_text **report, rv_error **error);
/* Reads a file of triangles as it is. */
int rv_mesh_read(const char *path, const rv_options *options, rv_mesh **mesh, rv_error **error);

typedef struct rv_surface {
    const double *points; /* three numbers of each */
    size_t point_count;
    const uint32_t *triangles; /* three points of each, from 0 */
    size_t triangle_count;
} rv_surface;

/* Meshes a surface of triangles anew: its faces, edges and corners are found. */
int rv_remesh(const rv_surface *surface, const rv_options *options, rv_mesh **mesh, rv_error **error);
/* Sets right what is wrong with one: gaps, holes, overlaps, intersections. */
int rv_heal(const rv_surface *surface, const rv_options *options, rv_mesh **mesh, rv_error **error);
/* Measures one, against a part unless that is NULL: JSON, as `check` in a mesh's report. */
int rv_check(const rv_surface *surface, const rv_part *part, const rv_options *options, rv_text **report, rv_error **error);
/* Against a part file or a STEP file. */
int rv_check_file(const rv_surface *surface, const char *path, const rv_options *options, rv_text **report, rv_error **error);

/* What is found in one before it is meshed: faces with areas and neighbors, edges with lengths, vertices, as JSON of `rvachev info --json`.
 * The options are those of triangles. Of a file, names of faces are heeded. */
int rv_triangles_info(const rv_surface *surface, const rv_options *options, rv_text **report, rv_error **error);
int rv_triangles_info_file(const char *path, const rv_options *options, rv_text **report, rv_error **error);
/* One measured beside what rv_remesh makes of it and what two simpler methods make, as JSON of `rvachev compare --json`. The options
 * volume and without are wrong here, png and color are those of rv_compare. */
int rv_compare_triangles(const rv_surface *surface, const rv_options *options, rv_text **report, rv_error **error);
int rv_compare_triangles_file(const char *path, const rv_options *options, rv_text **report, rv_error **error);

/* ------------------------------------------------------------------------------------------------------------ meshes */

/* Arrays are lent, see above. `count` is the number of points, triangles or edges. */
int rv_mesh_points(const rv_mesh *mesh, const double **xyz, size_t *count, rv_error **error);
int rv_mesh_triangles(const rv_mesh *mesh, const uint32_t **nodes, size_t *count, rv_error **error);
/* The face of each triangle, a number for rv_mesh_face_name. */
int rv_mesh_labels(const rv_mesh *mesh, const uint32_t **faces, size_t *count, rv_error **error);
/* Outward unit normals of the triangles, three numbers of each; zero where one has no area. */
int rv_mesh_normals(const rv_mesh *mesh, const double **xyz, size_t *count, rv_error **error);
/* Edges between two faces, where two surfaces of one face meet, and open ones: two nodes of each. */
int rv_mesh_feature_edges(const rv_mesh *mesh, const uint32_t **nodes, size_t *count, rv_error **error);
/* Nodes where borders of faces end or meet, and apexes; none where the method does not know them. */
int rv_mesh_corners(const rv_mesh *mesh, const uint32_t **nodes, size_t *count, rv_error **error);
/* Triangles, and nodes (those on borders included), of a group, of a face, or of faces whose names fit a pattern; ascending.
 * RV_INPUT where there is none. */
int rv_mesh_triangles_of(const rv_mesh *mesh, const char *name, const uint32_t **triangles, size_t *count, rv_error **error);
int rv_mesh_nodes_of(const rv_mesh *mesh, const char *name, const uint32_t **nodes, size_t *count, rv_error **error);

/* How the mesh bends at its nodes. Two magnitudes of each node, 1 over length, the larger one first: the principal curvatures, of the
 * angles between triangles around the node. RV_INPUT for a mesh that is no oriented manifold, here and in the next two. */
int rv_mesh_curvatures(const rv_mesh *mesh, const double **principal, size_t *count, rv_error **error);
/* By how much the angles around each node differ from a full turn, half of one on an open border: 0 where it is flat. */
int rv_mesh_angle_defects(const rv_mesh *mesh, const double **radians, size_t *count, rv_error **error);
/* What each node is by its curvature: 0 regular, 1 on a crease, 2 a corner. Nodes are compared with each other, so a mesh of a few
 * triangles without smooth places may have no corner. */
int rv_mesh_node_classes(const rv_mesh *mesh, const uint8_t **classes, size_t *count, rv_error **error);
/* How far each node is from the surface of a part, never less than it is; infinite where it is far from all of it. Room for a number of
 * each node. Of the options threads is heeded. */
int rv_mesh_distances(const rv_mesh *mesh, const rv_part *part, const rv_options *options, double *distances, rv_error **error);

/* Lists of texts: how many, and each by its number from 0. */
int rv_mesh_face_count(const rv_mesh *mesh, size_t *count, rv_error **error);
int rv_mesh_face_name(const rv_mesh *mesh, size_t index, const char **name, rv_error **error);
int rv_mesh_group_count(const rv_mesh *mesh, size_t *count, rv_error **error);
int rv_mesh_group_name(const rv_mesh *mesh, size_t index, const char **name, rv_error **error);
int rv_mesh_shortfall_count(const rv_mesh *mesh, size_t *count, rv_error **error);
int rv_mesh_shortfall(const rv_mesh *mesh, size_t index, const char **text, rv_error **error);
int rv_mesh_warning_count(const rv_mesh *mesh, size_t *count, rv_error **error);
int rv_mesh_warning(const rv_mesh *mesh, size_t index, const char **text, rv_error **error);

/* The borders of a plane figure, whose mesh is flat in z = 0: closed lines, 0 of them for any other mesh. The nodes of each are lent,
 * each node once, with the figure on the left: outer lines run counter-clockwise, those of holes clockwise. */
int rv_mesh_contour_count(const rv_mesh *mesh, size_t *count, rv_error **error);
int rv_mesh_contour(const rv_mesh *mesh, size_t index, const uint32_t **nodes, size_t *count, rv_error **error);
/* For each of these nodes the border of the edge from it to the next one, a number for rv_mesh_border_name. */
int rv_mesh_contour_borders(const rv_mesh *mesh, size_t index, const uint32_t **borders, size_t *count, rv_error **error);
int rv_mesh_border_count(const rv_mesh *mesh, size_t *count, rv_error **error);
int rv_mesh_border_name(const rv_mesh *mesh, size_t index, const char **name, rv_error **error);

/* JSON, described in docs/report.md; what was repaired for a healed mesh, "null" for one that was read. */
int rv_mesh_report(const rv_mesh *mesh, const char **text, rv_error **error);
/* 1 where the mesh is certified: closed (or meant to be open), a manifold, oriented, free of self-intersections. */
int rv_mesh_is_sound(const rv_mesh *mesh, int *sound, rv_error **error);
/* The unit of the part the mesh was made of; NULL where none was said. Files that have a place for it are told. */
int rv_mesh_units(const rv_mesh *mesh, const char **units, rv_error **error);
/* By extension: msh, inp, bdf, vtu, vtp, stl, obj, ply, off, mesh, su2, emesh, geo, 3mf, glb, xdmf, svg (plane figures). Formats with
 * named sets get a list of the names beside them, NAME.names.json. What a format cannot hold becomes a warning of the mesh. */
int rv_mesh_write(const rv_mesh *mesh, const char *path, const rv_options *options, rv_error **error);
/* Another mesh, with one face made anew on its true surface. Its edges have the option `size`, a length or a share of the mesh's
 * diagonal; of the others threads and force are heeded. Points and triangles of all other faces keep their places and their order,
 * and so does the face's border; new ones come last. The mesh may be of one solid of functions by the method leaf, of a CAD model,
 * of solids built from edges or of triangles. RV_USAGE for a name no face has, a size far too small, a plane figure, and a mesh joined
 * of several solids; RV_INPUT for a mesh that was read or healed, and for a face that has creases inside or does not lie on one surface,
 * as by other methods. */
int rv_mesh_remesh_face(const rv_mesh *mesh, const char *face, const rv_options *options, rv_mesh **made, rv_error **error);
/* One HTML page that shows the mesh in a browser, as `rvachev view` writes it; it needs no network. */
int rv_mesh_page(const rv_mesh *mesh, const char *title, rv_text **page, rv_error **error);
void rv_mesh_free(rv_mesh *mesh);

/* Draws a mesh as `rvachev render` does, without a screen. The options: view ("iso", "front", "back", "left", "right", "top", "bottom", or
 * "AZIMUTH,ELEVATION" in degrees), focus ("X,Y,Z,RADIUS" of the ball that fills the picture; the whole mesh does without), clip ("x=0",
 * "z=1.5,above"; may be said often), color ("face", "angle", "edge", "distance", "class"), edges ("none", "sharp", "all"), pixels
 * ("1200x900"), transparent ("true" for no background), legend ("false" for none). For the color distance either `part` is the part whose
 * surface the mesh should be of, or the option against names its file; otherwise `part` is NULL. */
int rv_mesh_picture(const rv_mesh *mesh, const rv_part *part, const rv_options *options, rv_picture **picture, rv_error **error);
/* Lent: red, green, blue and opacity of each pixel, 0 to 255, row by row from the top left; 4 * width * height bytes. */
int rv_picture_pixels(const rv_picture *picture, const uint8_t **rgba, size_t *width, size_t *height, rv_error **error);
/* A PNG file. */
int rv_picture_write(const rv_picture *picture, const char *path, rv_error **error);
void rv_picture_free(rv_picture *picture);

/* Values at a mesh's nodes, to be carried to other points, such as the nodes of a finer mesh. */
typedef struct rv_carry {
    const double *values; /* `width` numbers of each node of the mesh, in the order of its nodes */
    size_t width;
    const double *xyz; /* the points */
    size_t count;
    double *carried;   /* room for `width` numbers of each point */
    double *distances; /* room for how far each point is from the mesh, or NULL */
} rv_carry;

/* A point has the values at the nearest point of the mesh, linear within each triangle. No point is refused for being far away.
 * RV_INPUT for a mesh without triangles and for points that are not finite. */
int rv_mesh_carry(const rv_mesh *mesh, const rv_carry *what, rv_error **error);

/* Meshes joined to one: a node of one and the nearest node of another are one where they are no farther apart than the option "within",
 * a length or a share of the diagonal of all, 0.0001% unless said otherwise. Joined nodes stand where the first mesh has them, and
 * triangles keep their order. Faces, and groups, of the same name are one. RV_SHORT where a mesh shares no node with any other. The
 * report is JSON of `rvachev join --json`: it counts edges that are open, or of meshes that are inside out. */
int rv_mesh_join(const rv_mesh *const *meshes, size_t count, const rv_options *options, rv_mesh **joined, rv_error **error);

/* The shortest way over a mesh between the points of it that are nearest to two points; it may cross triangles. No change nearby makes
 * it shorter. Where ways on several sides of an obstacle are about as long, it may be none of the shortest. RV_INPUT where pieces of
 * the mesh do not hang together. */
int rv_mesh_path(const rv_mesh *mesh, const double *from, const double *to, rv_path **path, rv_error **error);
/* Lent; between two points it runs straight through one triangle. */
int rv_path_points(const rv_path *path, const double **xyz, size_t *count, rv_error **error);
int rv_path_length(const rv_path *path, double *length, rv_error **error);
void rv_path_free(rv_path *path);

/* ------------------------------------------------------------------------------------------------------------ prisms */

/* What is to be filled with layers of prisms: what a face sweeps along a vector, or the room between two faces of a mesh that have
 * the same triangles, moved along one vector. Just one of `to` and `along` is not NULL. */
typedef struct rv_sweep {
    const char *face;    /* the name of the bottom */
    const char *to;      /* the name of the top, or NULL */
    const double *along; /* three numbers in the mesh's unit, or NULL */
    size_t layers;       /* at least one, all equally thick */
} rv_sweep;

/* Every prism has a positive volume. RV_INPUT where faces do not match, walls between them are open or not straight, a prism is flat. */
int rv_mesh_sweep(const rv_mesh *mesh, const rv_sweep *sweep, rv_prisms **prisms, rv_error **error);
/* Arrays and names are lent. Layer by layer from the bottom, in each the order of the face's triangles. */
int rv_prisms_points(const rv_prisms *prisms, const double **xyz, size_t *count, rv_error **error);
/* Six nodes of each prism: three of the bottom, and those across from them, as gmsh and Abaqus have them. */
int rv_prisms_cells(const rv_prisms *prisms, const uint32_t **nodes, size_t *count, rv_error **error);
/* Sides on the boundary, four nodes of each, counter-clockwise seen from outside; a triangle has its third one twice. */
int rv_prisms_sides(const rv_prisms *prisms, const uint32_t **nodes, size_t *count, rv_error **error);
/* The name of each side, a number for rv_prisms_name: the face, what is across from it ("opposite" along a vector), then walls by the
 * faces beside the face ("side" where there is none). */
int rv_prisms_labels(const rv_prisms *prisms, const uint32_t **names, size_t *count, rv_error **error);
int rv_prisms_name_count(const rv_prisms *prisms, size_t *count, rv_error **error);
int rv_prisms_name(const rv_prisms *prisms, size_t index, const char **name, rv_error **error);
int rv_prisms_volume(const rv_prisms *prisms, double *volume, rv_error **error);
/* Hexahedra in place of pairs of prisms beside each other, in all layers alike; the prisms stay as they are. No angle of a
 * quadrilateral at the bottom or the top is farther than `off` degrees from a right one, and no two triangles are folded by more:
 * two equilateral ones are 30 degrees off. Of what is made rv_prisms_cells are those without a partner; points, names, volume stay. */
int rv_prisms_pair(const rv_prisms *prisms, double off, rv_prisms **paired, rv_error **error);
/* Eight nodes of each hexahedron: four of the bottom, and those across from them, as VTK, gmsh and Abaqus have them. 0 for prisms
 * that were not paired. */
int rv_prisms_hexahedra(const rv_prisms *prisms, const uint32_t **nodes, size_t *count, rv_error **error);
/* By extension: vtu, msh, inp, with sides by name. Of the options msh-version is heeded. */
int rv_prisms_write(const rv_prisms *prisms, const char *path, const rv_options *options, rv_error **error);
void rv_prisms_free(rv_prisms *prisms);

/* ------------------------------------------------------------------------------------------------------------ bricks */

/* Meshes that memory does not hold while they are made: a plan in a folder, bricks made by any number of processes that see this
 * folder, and one that merges them. Every part of it is what `rvachev plan`, `brick` and `merge` do, and goes together with them. */

/* A plan of bricks for a part file; counts[3] bricks along x, y and z, fewer where they would be narrower than 24 edges. */
int rv_bricks_plan(const char *path, const uint32_t *counts, const rv_options *options, const char *folder, rv_error **error);

/* The bricks that one of several processes makes, of one round. */
typedef struct rv_share {
    uint32_t number; /* from 1 to `of` */
    uint32_t of;
    uint32_t round; /* 1 to 3; each needs all shares of the one before */
} rv_share;

/* Makes the bricks of a share that are not there; all of all rounds where it is NULL. `made` is how many pieces were made. */
int rv_bricks_make(const char *folder, const rv_share *share, const rv_options *options, size_t *made, rv_error **error);
/* Writes the mesh of all bricks to a file, and gives its report as JSON (docs/report.md). RV_SHORT where it falls short; RV_INPUT where
 * pieces are missing or damaged; RV_FAILED for a mesh that is not sound, without the option force. */
int rv_bricks_merge(const char *folder, const char *path, const rv_options *options, rv_text **report, rv_error **error);

int rv_text_chars(const rv_text *text, const char **chars, rv_error **error);
void rv_text_free(rv_text *text);

#ifdef __cplusplus
}
#endif

#endif

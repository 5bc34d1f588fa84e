/* What a program may do wrong, and what it may ask of runs: each answer is looked at here. `quick` leaves out what takes long. */

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "rvachev.h"

#define HOLDS(what)                                                                                                                \
    do {                                                                                                                           \
        if (!(what)) {                                                                                                             \
            printf("line %d: not so: %s\n", __LINE__, #what);                                                                      \
            exit(1);                                                                                                               \
        }                                                                                                                          \
    } while (0)

static rv_error *error;

/* The call returned this status, with a message that holds this text. */
static void expect(int line, int got, int wanted, const char *text) {
    const char *message = rv_error_message(error);
    if (got != wanted || rv_error_status(error) != (wanted == RV_SHORT ? 0 : wanted) || !strstr(message, text)) {
        printf("line %d: status %d, not %d: %s\n", line, got, wanted, message);
        exit(1);
    }
    rv_error_free(error);
    error = NULL;
}
#define EXPECT(call, wanted, text) expect(__LINE__, call, wanted, text)
#define GOOD(call) EXPECT(call, RV_GOOD, "")

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---------------------------------------------------------------------------------------------------------------- NULL */

static void nulls(void) {
    static const double at[3] = {0, 0, 0}, bounds[6] = {0, 0, 0, 1, 1, 1};
    rv_options *options;
    rv_part *part;
    rv_mesh *mesh;
    rv_solid *solid, *other;
    rv_text *text;
    rv_run *run;
    const double *p;
    const uint32_t *t;
    const char *s;
    size_t n;
    int sound;
    double done, value;

    rv_error_free(NULL), rv_options_free(NULL), rv_run_free(NULL), rv_solid_free(NULL), rv_part_free(NULL), rv_mesh_free(NULL);
    rv_text_free(NULL);
    HOLDS(rv_error_status(NULL) == 0 && !*rv_error_message(NULL) && !rv_error_help(NULL) && !rv_error_file(NULL));
    HOLDS(!rv_error_line(NULL) && !rv_error_column(NULL) && !rv_error_user_code(NULL) && !rv_error_user(NULL));

    EXPECT(rv_options_new(NULL, &error), RV_USAGE, "options is NULL");
    EXPECT(rv_options_set(NULL, "size", "1", &error), RV_USAGE, "options is NULL");
    EXPECT(rv_options_set_run(NULL, NULL, &error), RV_USAGE, "options is NULL");
    EXPECT(rv_run_new(NULL, &error), RV_USAGE, "run is NULL");
    EXPECT(rv_run_cancel(NULL, &error), RV_USAGE, "run is NULL");
    EXPECT(rv_run_progress(NULL, NULL, 0, &done, &error), RV_USAGE, "run is NULL");
    EXPECT(rv_solid_parse(NULL, &solid, &error), RV_USAGE, "text is NULL");
    EXPECT(rv_solid_parse("sphere(1)", NULL, &error), RV_USAGE, "solid is NULL");
    EXPECT(rv_solid_box(NULL, at, &solid, &error), RV_USAGE, "lo is NULL");
    EXPECT(rv_solid_cylinder(1, at, NULL, &solid, &error), RV_USAGE, "to is NULL");
    EXPECT(rv_solid_cone(NULL, at, at, &solid, &error), RV_USAGE, "radii is NULL");
    EXPECT(rv_solid_torus(NULL, NULL, NULL, &solid, &error), RV_USAGE, "radii is NULL");
    EXPECT(rv_solid_half_space(NULL, NULL, &solid, &error), RV_USAGE, "normal is NULL");
    EXPECT(rv_solid_union(NULL, 2, &solid, &error), RV_USAGE, "solids is NULL");
    const rv_solid *none[1] = {NULL};
    EXPECT(rv_solid_intersection(none, 1, &solid, &error), RV_USAGE, "a solid is NULL");
    EXPECT(rv_solid_difference(NULL, NULL, &solid, &error), RV_USAGE, "a is NULL");
    EXPECT(rv_solid_complement(NULL, &solid, &error), RV_USAGE, "a is NULL");
    EXPECT(rv_solid_blend(NULL, NULL, 1, &solid, &error), RV_USAGE, "a is NULL");
    EXPECT(rv_solid_move(NULL, at, &solid, &error), RV_USAGE, "a is NULL");
    EXPECT(rv_solid_rotate(NULL, 1, NULL, &solid, &error), RV_USAGE, "axis is NULL");
    EXPECT(rv_solid_scale(NULL, 1, &solid, &error), RV_USAGE, "a is NULL");
    EXPECT(rv_solid_name(NULL, "a", &solid, &error), RV_USAGE, "a is NULL");
    EXPECT(rv_solid_size(NULL, 1, &solid, &error), RV_USAGE, "a is NULL");
    EXPECT(rv_solid_apply(NULL, "scale(2)", &solid, &error), RV_USAGE, "a is NULL");
    EXPECT(rv_solid_field(NULL, &solid, &error), RV_USAGE, "field is NULL");
    rv_field empty;
    memset(&empty, 0, sizeof empty);
    EXPECT(rv_solid_field(&empty, &solid, &error), RV_USAGE, "function is NULL");
    EXPECT(rv_solid_grid(NULL, bounds, at, &solid, &error), RV_USAGE, "counts is NULL");
    EXPECT(rv_part_parse(NULL, NULL, &part, &error), RV_USAGE, "source is NULL");
    EXPECT(rv_part_load(NULL, NULL, &part, &error), RV_USAGE, "path is NULL");
    EXPECT(rv_part_new(NULL, 0, &part, &error), RV_INPUT, "needs a solid");
    EXPECT(rv_part_set_units(NULL, "mm", &error), RV_USAGE, "part is NULL");
    EXPECT(rv_part_set_rsystem(NULL, "R0", &error), RV_USAGE, "part is NULL");
    EXPECT(rv_part_set_domain(NULL, NULL, &error), RV_USAGE, "part is NULL");
    EXPECT(rv_part_group(NULL, "a", "b", &error), RV_USAGE, "part is NULL");
    EXPECT(rv_part_info(NULL, &text, &error), RV_USAGE, "part is NULL");
    EXPECT(rv_part_values(NULL, 1, at, &value, &error), RV_USAGE, "part is NULL");
    EXPECT(rv_part_gradients(NULL, 1, at, NULL, &error), RV_USAGE, "gradients is NULL");
    EXPECT(rv_part_mesh(NULL, NULL, &mesh, &error), RV_USAGE, "part is NULL");
    HOLDS(mesh == NULL);
    EXPECT(rv_part_write_step(NULL, "a.step", &error), RV_USAGE, "part is NULL");
    EXPECT(rv_mesh_file(NULL, NULL, &mesh, &error), RV_USAGE, "path is NULL");
    EXPECT(rv_mesh_read(NULL, NULL, &mesh, &error), RV_USAGE, "path is NULL");
    EXPECT(rv_remesh(NULL, NULL, &mesh, &error), RV_USAGE, "surface is NULL");
    EXPECT(rv_heal(NULL, NULL, &mesh, &error), RV_USAGE, "surface is NULL");
    EXPECT(rv_check(NULL, NULL, NULL, &text, &error), RV_USAGE, "surface is NULL");
    EXPECT(rv_check_file(NULL, "a.step", NULL, &text, &error), RV_USAGE, "surface is NULL");
    rv_surface hollow = {NULL, 3, NULL, 1};
    EXPECT(rv_heal(&hollow, NULL, &mesh, &error), RV_USAGE, "surface.points is NULL");
    EXPECT(rv_mesh_points(NULL, &p, &n, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_triangles(NULL, &t, &n, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_labels(NULL, &t, &n, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_normals(NULL, &p, &n, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_feature_edges(NULL, &t, &n, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_corners(NULL, &t, &n, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_triangles_of(NULL, "a", &t, &n, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_nodes_of(NULL, "a", &t, &n, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_face_count(NULL, &n, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_face_name(NULL, 0, &s, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_group_count(NULL, &n, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_group_name(NULL, 0, &s, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_shortfall_count(NULL, &n, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_shortfall(NULL, 0, &s, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_warning_count(NULL, &n, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_warning(NULL, 0, &s, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_report(NULL, &s, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_is_sound(NULL, &sound, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_mesh_write(NULL, "a.msh", NULL, &error), RV_USAGE, "mesh is NULL");
    EXPECT(rv_text_chars(NULL, &s, &error), RV_USAGE, "text is NULL");

    /* Without a place for errors only the status is told. */
    HOLDS(rv_options_set(NULL, "size", "1", NULL) == RV_USAGE);
    HOLDS(rv_options_new(&options, NULL) == RV_GOOD);
    EXPECT(rv_options_set(options, NULL, "1", &error), RV_USAGE, "name is NULL");
    EXPECT(rv_options_set(options, "size", NULL, &error), RV_USAGE, "value is NULL");
    rv_options_free(options);
    GOOD(rv_run_new(&run, &error));
    EXPECT(rv_run_progress(run, NULL, 8, &done, &error), RV_USAGE, "stage is NULL");
    rv_run_free(run);
    GOOD(rv_solid_sphere(1, NULL, &solid, &error));
    EXPECT(rv_solid_sphere(1, NULL, NULL, &error), RV_USAGE, "solid is NULL");
    EXPECT(rv_solid_name(solid, NULL, &other, &error), RV_USAGE, "name is NULL");
    rv_solid_free(solid);
}

/* ------------------------------------------------------------------------------------------------------------ bad input */

static void bad_input(void) {
    rv_options *options;
    rv_part *part;
    rv_mesh *mesh;
    rv_solid *solid;
    rv_text *text;
    GOOD(rv_options_new(&options, &error));
    EXPECT(rv_options_set(options, "size", "-1", &error), RV_USAGE, "a size is a positive length or a share");
    EXPECT(rv_options_set(options, "size", "2 percent", &error), RV_USAGE, "\"2 percent\"");
    EXPECT(rv_options_set(options, "sise", "1", &error), RV_USAGE, "there is no option \"sise\"; there are: size");
    EXPECT(rv_options_set(options, "method", "magic", &error), RV_USAGE, "unknown method magic");
    EXPECT(rv_options_set(options, "threads", "many", &error), RV_USAGE, "threads must be a whole number");
    EXPECT(rv_options_set(options, "threads", "1000000", &error), RV_USAGE, "at most 1024");
    EXPECT(rv_options_set(options, "define", "radius", &error), RV_USAGE, "NAME=VALUE");
    EXPECT(rv_options_set(options, "tol", "nan", &error), RV_USAGE, "positive");
    EXPECT(rv_options_set(options, "size", "\xff", &error), RV_USAGE, "UTF-8");
    rv_options_free(options);

    int status = rv_part_parse("a = 1\npart(sphare(1))", NULL, &part, &error);
    HOLDS(status == RV_INPUT && part == NULL && rv_error_line(error) == 2 && rv_error_column(error) == 6);
    HOLDS(rv_error_help(error) && strstr(rv_error_help(error), "sphere") && !rv_error_file(error));
    EXPECT(status, RV_INPUT, "line 2, column 6");
    status = rv_part_load("/no/such.py", NULL, &part, &error);
    HOLDS(rv_error_file(error) && !strcmp(rv_error_file(error), "/no/such.py"));
    EXPECT(status, RV_INPUT, "cannot read");
    /* Places are those of the text that was given. */
    status = rv_solid_parse("sphere(1) |\n  box(size=(1, 2))", &solid, &error);
    HOLDS(rv_error_line(error) == 2 && rv_error_column(error) == 12);
    EXPECT(status, RV_INPUT, "line 2, column 12");
    EXPECT(rv_solid_sphere(-1, NULL, &solid, &error), RV_INPUT, "positive");
    EXPECT(rv_solid_sphere(NAN, NULL, &solid, &error), RV_INPUT, "finite");
    HOLDS(solid == NULL);

    static const double flat[6] = {0, 0, 0, 1, 1, 0}, wild[9] = {0, 0, 0, 1, 0, 0, 0, INFINITY, 0}, plain[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint32_t one[3] = {0, 1, 2}, far[3] = {0, 1, 7};
    static const size_t counts[3] = {2, 2, 2}, thin[3] = {2, 1, 2}, huge[3] = {(size_t)1 << 40, (size_t)1 << 40, 2};
    static const double nans[8] = {1, 1, 1, 1, 1, NAN, 1, 1}, cube[6] = {0, 0, 0, 1, 1, 1};
    EXPECT(rv_solid_grid(counts, flat, nans, &solid, &error), RV_INPUT, "lo < hi");
    EXPECT(rv_solid_grid(counts, cube, nans, &solid, &error), RV_INPUT, "[1, 0, 1]");
    EXPECT(rv_solid_grid(thin, cube, nans, &solid, &error), RV_INPUT, "two points");
    EXPECT(rv_solid_grid(huge, cube, nans, &solid, &error), RV_USAGE, "");
    rv_surface surface = {wild, 3, one, 1};
    EXPECT(rv_check(&surface, NULL, NULL, &text, &error), RV_INPUT, "point 2");
    surface.points = plain, surface.triangles = far;
    EXPECT(rv_check(&surface, NULL, NULL, &text, &error), RV_INPUT, "triangle 0");
    surface.triangle_count = SIZE_MAX / 2;
    EXPECT(rv_check(&surface, NULL, NULL, &text, &error), RV_USAGE, "cannot have");

    /* Two built solids take no part in set operations, but make a part. */
    rv_solid *pipe, *ball;
    GOOD(rv_solid_parse("extrude_edges([circle(2), circle(1)], \"z\", 3).name(\"pipe\")", &pipe, &error));
    GOOD(rv_solid_sphere(1, NULL, &ball, &error));
    EXPECT(rv_solid_difference(pipe, ball, &solid, &error), RV_INPUT, "built from edges");
    const rv_solid *both[2] = {pipe, ball}, *twice[2] = {ball, ball};
    EXPECT(rv_part_new(twice, 2, &part, &error), RV_INPUT, "one solid of R-functions");
    GOOD(rv_part_new(both, 2, &part, &error));
    EXPECT(rv_part_set_units(part, "parsec", &error), RV_INPUT, "parsec");
    EXPECT(rv_part_group(part, "", "", &error), RV_INPUT, "needs a name");
    GOOD(rv_part_set_units(part, "in", &error));
    GOOD(rv_part_info(part, &text, &error));
    const char *info;
    GOOD(rv_text_chars(text, &info, &error));
    HOLDS(info[0] == '{' && strstr(info, "\"in\""));
    rv_text_free(text);
    rv_part_free(part);

    /* A mesh that is there answers what is not there. */
    const rv_solid *alone[1] = {ball};
    GOOD(rv_part_new(alone, 1, &part, &error));
    GOOD(rv_part_group(part, "nothing", "box.*", &error));
    rv_options *coarse;
    GOOD(rv_options_new(&coarse, &error));
    GOOD(rv_options_set(coarse, "size", "0.7", &error));
    EXPECT(rv_part_mesh(part, coarse, &mesh, &error), RV_INPUT, "box.*");
    rv_part_free(part);
    GOOD(rv_part_new(alone, 1, &part, &error));
    GOOD(rv_part_mesh(part, coarse, &mesh, &error));
    const uint32_t *t, *again;
    const char *name;
    size_t n;
    EXPECT(rv_mesh_triangles_of(mesh, "torus", &t, &n, &error), RV_INPUT, "no group and no face \"torus\"");
    HOLDS(t == NULL && n == 0);
    EXPECT(rv_mesh_face_name(mesh, 1, &name, &error), RV_USAGE, "no face 1");
    EXPECT(rv_mesh_write(mesh, "a.docx", NULL, &error), RV_USAGE, ".docx");
    EXPECT(rv_mesh_points(mesh, NULL, &n, &error), RV_USAGE, "NULL");
    /* What was lent stays where it is. */
    GOOD(rv_mesh_nodes_of(mesh, "sphere1", &t, &n, &error));
    GOOD(rv_mesh_nodes_of(mesh, "s*", &again, &n, &error));
    GOOD(rv_mesh_nodes_of(mesh, "sphere1", &again, &n, &error));
    HOLDS(t == again && n > 20 && t[n - 1] == n - 1);
    rv_part_free(part), rv_options_free(coarse), rv_mesh_free(mesh), rv_solid_free(pipe), rv_solid_free(ball);
}

/* ----------------------------------------------------------------------------------------------------------- functions */

typedef struct {
    pthread_mutex_t lock;
    int inside, most, calls, released, stop_after, nest;
} counter;

static int ball(size_t n, const double *xyz, double *value, double *gradient, void *user) {
    counter *c = user;
    pthread_mutex_lock(&c->lock);
    c->inside++, c->calls++;
    if (c->inside > c->most) c->most = c->inside;
    int stop = c->stop_after && c->calls > c->stop_after, nest = c->nest && c->calls == c->nest;
    pthread_mutex_unlock(&c->lock);
    for (size_t i = 0; i < n; i++) {
        const double *p = xyz + 3 * i;
        value[i] = 1 - sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    }
    if (gradient) stop = 1;
    if (nest) {
        /* A function may use the library itself. */
        rv_part *part;
        rv_mesh *mesh;
        rv_options *options;
        double at[3] = {0, 0, 0}, v;
        if (rv_part_parse("part(box(size=(1, 1, 1)))", NULL, &part, NULL) || rv_part_values(part, 1, at, &v, NULL) || !(v > 0)) stop = 1;
        if (rv_options_new(&options, NULL) || rv_options_set(options, "size", "0.5", NULL)) stop = 1;
        if (rv_part_mesh(part, options, &mesh, NULL)) stop = 1;
        rv_mesh_free(mesh), rv_options_free(options), rv_part_free(part);
    }
    pthread_mutex_lock(&c->lock);
    c->inside--;
    pthread_mutex_unlock(&c->lock);
    return stop ? 42 : 0;
}

static void released(void *user) { ((counter *)user)->released++; }

static void functions(void) {
    static const double bounds[6] = {-1.5, -1.5, -1.5, 1.5, 1.5, 1.5};
    counter c = {.stop_after = 30};
    pthread_mutex_init(&c.lock, NULL);
    rv_field field = {.function = ball, .user = &c, .release = released, .lipschitz = -1, .bounds = bounds};
    rv_solid *solid, *moved;
    rv_part *part;
    rv_mesh *mesh;
    rv_options *options;
    GOOD(rv_options_new(&options, &error));
    GOOD(rv_options_set(options, "size", "0.4", &error));
    EXPECT(rv_solid_field(&field, &solid, &error), RV_INPUT, "lipschitz");
    HOLDS(c.released == 0);
    field.lipschitz = 1;
    GOOD(rv_solid_field(&field, &solid, &error));
    static const double by[3] = {5, 0, 0};
    GOOD(rv_solid_move(solid, by, &moved, &error));
    rv_solid_free(solid);
    const rv_solid *all[1] = {moved};
    GOOD(rv_part_new(all, 1, &part, &error));
    rv_solid_free(moved);

    /* The code comes back, and whose it was. */
    int status = rv_part_mesh(part, options, &mesh, &error);
    HOLDS(mesh == NULL && rv_error_user_code(error) == 42 && rv_error_user(error) == &c);
    EXPECT(status, RV_STOPPED, "42");
    double at[6] = {5, 0, 0, 5, 0, 0.25}, v[2], g[6];
    EXPECT(rv_part_values(part, 2, at, v, &error), RV_STOPPED, "42");
    GOOD(rv_part_set_rsystem(part, "minmax", &error));
    /* Afterwards it is as if nothing had been. */
    c.stop_after = 0, c.most = 0, c.calls = 0, c.nest = 60;
    GOOD(rv_part_values(part, 2, at, v, &error));
    HOLDS(fabs(v[0] - 1) < 1e-9 && fabs(v[1] - 0.75) < 1e-9);
    GOOD(rv_part_gradients(part, 1, at + 3, g, &error));
    HOLDS(fabs(g[2] + 1) < 1e-6 && fabs(g[0]) < 1e-6);
    int made = rv_part_mesh(part, options, &mesh, &error);
    HOLDS(made == RV_GOOD && mesh && c.most == 1 && c.calls > 60 && c.inside == 0);
    const double *p;
    size_t n;
    GOOD(rv_mesh_points(mesh, &p, &n, &error));
    for (size_t i = 0; i < n; i++) HOLDS(fabs(hypot(hypot(p[3 * i] - 5, p[3 * i + 1]), p[3 * i + 2]) - 1) < 1e-6);
    rv_mesh_free(mesh), rv_options_free(options);
    HOLDS(c.released == 0);
    rv_part_free(part);
    HOLDS(c.released == 1);
}

/* ----------------------------------------------------------------------------------------------------------------- runs */

typedef struct {
    const char *path;
    rv_options *options;
    int status;
    double ended;
} call;

static void *meshed(void *user) {
    call *c = user;
    rv_mesh *mesh;
    c->status = rv_mesh_file(c->path, c->options, &mesh, NULL);
    c->ended = now();
    rv_mesh_free(mesh);
    return NULL;
}

typedef struct {
    const rv_part *part;
    rv_options *options;
    rv_mesh *mesh;
    int status;
} share;

static void *meshed_of_part(void *user) {
    share *s = user;
    s->status = rv_part_mesh(s->part, s->options, &s->mesh, NULL);
    return NULL;
}

/* Several threads mesh one part at once, each call with threads of its own, and get the same bytes. */
static void shared(void) {
    rv_part *part;
    share all[4];
    pthread_t threads[4];
    static const char *const counts[4] = {"1", "2", "3", "0"};
    GOOD(rv_part_parse("part(box(size=(1, 1, 1)) - sphere(0.6))", NULL, &part, &error));
    for (int i = 0; i < 4; i++) {
        all[i].part = part;
        GOOD(rv_options_new(&all[i].options, &error));
        GOOD(rv_options_set(all[i].options, "size", "0.15", &error));
        GOOD(rv_options_set(all[i].options, "threads", counts[i], &error));
        HOLDS(!pthread_create(&threads[i], NULL, meshed_of_part, &all[i]));
    }
    const double *p[4];
    const uint32_t *t[4];
    size_t n[4], m[4];
    for (int i = 0; i < 4; i++) {
        pthread_join(threads[i], NULL);
        HOLDS(all[i].status == RV_GOOD);
        GOOD(rv_mesh_points(all[i].mesh, &p[i], &n[i], &error));
        GOOD(rv_mesh_triangles(all[i].mesh, &t[i], &m[i], &error));
        HOLDS(n[i] == n[0] && m[i] == m[0] && n[0] > 100);
        HOLDS(!memcmp(p[i], p[0], 3 * n[0] * sizeof(double)) && !memcmp(t[i], t[0], 3 * m[0] * sizeof(uint32_t)));
    }
    for (int i = 0; i < 4; i++) rv_mesh_free(all[i].mesh), rv_options_free(all[i].options);
    rv_part_free(part);
}

static void cancelled(const char *path) {
    call c = {.path = path};
    rv_run *run;
    GOOD(rv_run_new(&run, &error));
    GOOD(rv_options_new(&c.options, &error));
    GOOD(rv_options_set(c.options, "size", "0.3%", &error));
    GOOD(rv_options_set_run(c.options, run, &error));
    pthread_t thread;
    HOLDS(!pthread_create(&thread, NULL, meshed, &c));
    char stage[40] = "";
    double done = 0, start = now();
    while (!stage[0] || now() < start + 0.7) {
        struct timespec nap = {0, 10000000};
        nanosleep(&nap, NULL);
        GOOD(rv_run_progress(run, stage, sizeof stage, &done, &error));
        HOLDS(done >= 0 && done <= 1 && now() < start + 60);
    }
    char little[3];
    GOOD(rv_run_progress(run, little, sizeof little, &done, &error));
    HOLDS(strlen(little) <= 2);
    double asked = now();
    GOOD(rv_run_cancel(run, &error));
    pthread_join(thread, NULL);
    printf("cancelled in stage %s after %.3f seconds\n", stage, c.ended - asked);
    HOLDS(c.status == RV_CANCELLED);
    /* A cancelled run stays so. */
    rv_mesh *mesh;
    EXPECT(rv_mesh_file(path, c.options, &mesh, &error), RV_CANCELLED, "cancelled");
    rv_options_free(c.options), rv_run_free(run);
}

/* ----------------------------------------------------------------------------------------------------------------- leaks */

/* Kilobytes of memory in use. */
static long resident(void) {
    FILE *f = fopen("/proc/self/status", "r");
    char line[200];
    long kb = -1;
    while (f && fgets(line, sizeof line, f)) sscanf(line, "VmRSS: %ld", &kb);
    if (f) fclose(f);
    return kb;
}

/* A few calls of most kinds, good and bad. */
static void small(void) {
    rv_part *part;
    rv_options *options;
    rv_mesh *mesh;
    rv_solid *a, *b;
    const uint32_t *t;
    const double *p;
    const char *report;
    size_t n;
    GOOD(rv_options_new(&options, &error));
    GOOD(rv_options_set(options, "size", "0.8", &error));
    GOOD(rv_options_set(options, "threads", "1", &error));
    EXPECT(rv_options_set(options, "size", "nothing", &error), RV_USAGE, "size");
    GOOD(rv_solid_parse("box(size=(1, 1, 1)).name(\"body\")", &a, &error));
    GOOD(rv_solid_size(a, 0.9, &b, &error));
    const rv_solid *all[1] = {b};
    GOOD(rv_part_new(all, 1, &part, &error));
    GOOD(rv_part_group(part, "held", "body.xmin", &error));
    GOOD(rv_part_mesh(part, options, &mesh, &error));
    GOOD(rv_mesh_nodes_of(mesh, "held", &t, &n, &error));
    GOOD(rv_mesh_normals(mesh, &p, &n, &error));
    GOOD(rv_mesh_feature_edges(mesh, &t, &n, &error));
    GOOD(rv_mesh_report(mesh, &report, &error));
    EXPECT(rv_mesh_nodes_of(mesh, "none", &t, &n, &error), RV_INPUT, "none");
    rv_mesh_free(mesh), rv_part_free(part), rv_solid_free(a), rv_solid_free(b), rv_options_free(options);
}

int main(int argc, char **argv) {
    HOLDS(rv_version()[0]);
    nulls();
    bad_input();
    functions();
    small();
    if (argc > 1 && !strcmp(argv[1], "quick")) {
        puts("quick done");
        return 0;
    }
    shared();
    for (int i = 0; i < 100; i++) small();
    long before = resident();
    for (int i = 0; i < 1000; i++) small();
    long after = resident();
    printf("leak before %ld after %ld grown %ld\n", before, after, after - before);
    if (argc > 1) cancelled(argv[1]);
    puts("done");
    return 0;
}

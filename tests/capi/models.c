/* What is told of STEP models, methods compared, and a mesh made brick by brick. Arguments: a STEP file of a ball, one of a bar with a
 * face gone, a part file of a cube with two bores, a folder for files. */

#include <stdio.h>
#include <string.h>

#include "need.h"

/* Prints a text behind a word and frees it. */
static void show(const char *word, int status, rv_text *text) {
    const char *chars = NULL;
    rv_text_chars(text, &chars, NULL);
    printf("%s %d %s\n", word, status, chars ? chars : "");
    rv_text_free(text);
}

static int bricks(const char *part, const char *folder) {
    const uint32_t counts[3] = {2, 1, 1}, none[3] = {2, 0, 1};
    rv_options *options, *fine, *other;
    rv_text *report;
    size_t made, all = 0, again;
    char plan[1000], path[1100];
    snprintf(plan, sizeof plan, "%s/plan", folder);
    NEED(rv_options_new(&options, &error));
    NEED(rv_options_set(options, "size", "0.04", &error));
    NEED(rv_options_new(&fine, &error));
    NEED(rv_options_set(fine, "refine", "sphere=0,0,0,1:0.01", &error));
    WRONG(rv_bricks_plan(NULL, counts, options, plan, &error), RV_USAGE, "path is NULL");
    WRONG(rv_bricks_plan(part, NULL, options, plan, &error), RV_USAGE, "counts is NULL");
    WRONG(rv_bricks_plan(part, none, options, plan, &error), RV_USAGE, "not 0");
    WRONG(rv_bricks_plan(part, counts, options, NULL, &error), RV_USAGE, "folder is NULL");
    WRONG(rv_bricks_plan(part, counts, fine, plan, &error), RV_USAGE, "refine");
    NEED(rv_options_new(&other, &error));
    NEED(rv_options_set(other, "sequence", "N*10", &error));
    WRONG(rv_bricks_plan(part, counts, other, plan, &error), RV_USAGE, "sequence");
    WRONG(rv_bricks_plan("a.step", counts, options, plan, &error), RV_USAGE, "a.step");
    WRONG(rv_bricks_make(plan, NULL, NULL, &made, &error), RV_INPUT, "plan");
    NEED(rv_bricks_plan(part, counts, options, plan, &error));
    snprintf(path, sizeof path, "%s/cube.stl", folder);
    WRONG(rv_bricks_merge(plan, path, NULL, &report, &error), RV_INPUT, "");
    if (report) return 5;
    rv_share share = {1, 2, 1};
    for (share.round = 1; share.round <= 3; share.round++)
        for (share.number = 1; share.number <= 2; share.number++) {
            NEED(rv_bricks_make(plan, &share, options, &made, &error));
            all += made;
        }
    NEED(rv_bricks_make(plan, NULL, NULL, &again, &error));
    printf("bricks made %zu again %zu\n", all, again);
    share.round = 1, share.number = 3;
    WRONG(rv_bricks_make(plan, &share, NULL, &made, &error), RV_USAGE, "no share 3 of 2");
    share.number = 1, share.round = 4;
    WRONG(rv_bricks_make(plan, &share, NULL, &made, &error), RV_USAGE, "not 4");
    WRONG(rv_bricks_make(NULL, NULL, NULL, &made, &error), RV_USAGE, "folder is NULL");
    WRONG(rv_bricks_make(plan, NULL, NULL, NULL, &error), RV_USAGE, "made is NULL");
    WRONG(rv_bricks_merge(NULL, path, NULL, &report, &error), RV_USAGE, "folder is NULL");
    WRONG(rv_bricks_merge(plan, NULL, NULL, &report, &error), RV_USAGE, "path is NULL");
    WRONG(rv_bricks_merge(plan, path, NULL, NULL, &error), RV_USAGE, "report is NULL");
    WRONG(rv_bricks_merge(plan, "a.docx", NULL, &report, &error), RV_USAGE, "docx");
    int status = rv_bricks_merge(plan, path, NULL, &report, &error);
    show("merged", status, report);
    rv_options_free(options), rv_options_free(fine), rv_options_free(other);
    return 0;
}

int main(int argc, char **argv) {
    rv_part *part;
    rv_options *options;
    rv_text *text;
    int status;
    if (argc != 5) return 2;
    for (int i = 1; i <= 2; i++) {
        status = rv_step_check(argv[i], NULL, &text, &error);
        show(i == 1 ? "ball_check" : "bar_check", status, text);
        status = rv_step_info(argv[i], NULL, &text, &error);
        show(i == 1 ? "ball_info" : "bar_info", status, text);
    }
    NEED(rv_options_new(&options, &error));
    NEED(rv_options_set(options, "size", "0.1", &error));
    NEED(rv_part_load(argv[3], NULL, &part, &error));
    status = rv_compare(part, options, &text, &error);
    show("compared", status, text);
    NEED(rv_options_set(options, "volume", "0.01", &error));
    WRONG(rv_compare(part, options, &text, &error), RV_USAGE, "neither volume");
    WRONG(rv_compare(NULL, options, &text, &error), RV_USAGE, "part is NULL");
    WRONG(rv_compare(part, options, NULL, &error), RV_USAGE, "report is NULL");
    WRONG(rv_step_check(NULL, NULL, &text, &error), RV_USAGE, "path is NULL");
    WRONG(rv_step_check("no.step", NULL, &text, &error), RV_INPUT, "no.step");
    WRONG(rv_step_check(argv[1], NULL, NULL, &error), RV_USAGE, "report is NULL");
    WRONG(rv_step_info(NULL, NULL, &text, &error), RV_USAGE, "path is NULL");
    WRONG(rv_step_info("no.step", NULL, &text, &error), RV_INPUT, "no.step");
    if (text) return 6;
    rv_part_free(part), rv_options_free(options);
    return bricks(argv[3], argv[4]);
}

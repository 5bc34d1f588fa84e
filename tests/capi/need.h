/* What the programs beside this file check calls by. */

#ifndef NEED_H
#define NEED_H

#include <stdio.h>
#include <string.h>

#include "rvachev.h"

static rv_error *error;

#define NEED(call)                                                                                                \
    do {                                                                                                          \
        if ((call) != RV_GOOD) {                                                                                  \
            printf("line %d: %s\n", __LINE__, rv_error_message(error));                                           \
            return 1;                                                                                             \
        }                                                                                                         \
    } while (0)

#define WRONG(call, wanted, text)                                                                                 \
    do {                                                                                                          \
        int got = (call);                                                                                         \
        if (got != (wanted) || !strstr(rv_error_message(error), text)) {                                          \
            printf("line %d: %d %s\n", __LINE__, got, rv_error_message(error));                                   \
            return 1;                                                                                             \
        }                                                                                                         \
        rv_error_free(error), error = NULL;                                                                       \
    } while (0)

#endif

/* Written by muspin: what a unit gives to the interface in fmi.c. Values in the order of modelDescription.xml. */
#ifndef UNIT_H
#define UNIT_H

#include "unit_sizes.h"

typedef struct unit unit;
struct unit_base {
    double value[UNIT_VARIABLES]; /* time, inputs, outputs */
    long done;                    /* steps of its own that are done */
};

extern const unsigned long unit_bytes;
extern const char unit_token[];
struct unit_base *unit_of(unit *u);
/* Everything to its start. */
void unit_start(unit *u);
/* Runs until a time, s. */
void unit_advance(unit *u, double end_s);

#endif

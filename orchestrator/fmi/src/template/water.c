/* A reservoir of your own as an FMU (FMI 3.0, co-simulation): README.md says how to build, test and use it.
 *
 * SI units, per metre of dam. x points downstream, y up from the heel; n is the unit normal of the wet face, out of the water
 * into the dam. wet_face.h has the points of the face. */

#include "fmi3.h"
#include "wet_face.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ==== Your part: the values of the unit, its start, one step ============================================================= */

/* What the input interface_acceleration means; say the same by `acceleration` in the scene.
 *   0, "end":  a, the acceleration at the end of the step; water without memory answers p = -A a.
 *   1, "mean": its mean over the step; then p = -A (1.5 mean - 0.5 mean of the step before), for steps of equal length. */
#define ACCELERATION_IS_MEAN 0

/* Everything that the unit knows. It is saved, restored and written out as it is, byte for byte: values and arrays of double, no
 * pointers. A repeated step begins from a restored State and must give the same bits. */
typedef struct {
    /* Inputs. */
    double interface_acceleration[POINTS]; /* m/s2 along n, total: that of the ground is in it */
    double ground_acceleration[2];         /* m/s2 along x and y, at the end of the step; it moves the bed */
    /* Parameters. */
    double water_density; /* kg/m3 */
    double gravity;       /* m/s2 */
    /* Outputs. */
    double interface_pressure[POINTS];   /* Pa, at the end of the step: excess over hydrostatic, p > 0 in compression */
    double hydrostatic_pressure[POINTS]; /* Pa */
    /* Memory: what the next step has to know of this one. */
    double mean_before[POINTS];
    double length_before;
} State;

static const State START = {.water_density = DENSITY, .gravity = GRAVITY};

static const double WATER_DEPTH[1] = {DEPTH};

/* The variables by the value references of fmu/modelDescription.xml; a new one needs a line in both. */
static const Variable VARIABLES[] = {
    INPUT(1, interface_acceleration),
    INPUT(2, ground_acceleration),
    OUTPUT(10, interface_pressure),
    OUTPUT(11, hydrostatic_pressure),
    CONSTANT(20, X),
    CONSTANT(21, Y),
    CONSTANT(22, NORMAL_X),
    CONSTANT(23, NORMAL_Y),
    CONSTANT(24, LENGTH),
    CONSTANT(30, WATER_DEPTH),
    PARAMETER(31, water_density),
    PARAMETER(34, gravity),
};

/* Prepares the unit at the start time, at rest, from its parameters and first inputs; it may be called several times. Returns
 * NULL, or what is wrong. */
static const char *start(State *s)
{
    if (!(s->water_density > 0.0 && s->gravity > 0.0))
        return "water_density and gravity must be above 0";
    for (int i = 0; i < POINTS; i++)
        s->hydrostatic_pressure[i] = s->water_density * s->gravity * (DEPTH - Y[i]);
    return NULL;
}

/* Takes a step of `length` (s) from `time`. The inputs are those of its end. Returns NULL, or why it failed. */
static const char *step(State *s, double time, double length)
{
    (void)time;
    const double before = s->length_before > 0.0 ? s->length_before : length;
    for (int i = 0; i < POINTS; i++) {
        double a = s->interface_acceleration[i];
        if (ACCELERATION_IS_MEAN)
            a += (a - s->mean_before[i]) * length / (length + before);
        /* Westergaard's added mass. A face that moves into the water, a < 0, has p > 0. */
        s->interface_pressure[i] = -7.0 / 8.0 * s->water_density * sqrt(DEPTH * (DEPTH - Y[i])) * a;
        s->mean_before[i] = s->interface_acceleration[i];
    }
    s->length_before = length;
    return NULL;
}


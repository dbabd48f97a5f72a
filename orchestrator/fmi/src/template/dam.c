/* A dam of your own as an FMU (FMI 3.0, co-simulation): README.md says how to build, test and use it.
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

/* Everything that the unit knows. It is saved, restored and written out as it is, byte for byte: values and arrays of double, no
 * pointers. A repeated step begins from a restored State and must give the same bits. */
typedef struct {
    /* Inputs. */
    double interface_pressure[POINTS];   /* Pa, at the end of the step: excess over hydrostatic, p > 0 in compression */
    double hydrostatic_pressure[POINTS]; /* Pa, fixed after the start */
    double ground_acceleration[2];       /* m/s2 along x and y, at the end of the step */
    /* Parameters. */
    double mass;          /* kg/m, that sways */
    double stiffness;     /* Pa: force (N/m) over sway (m) */
    double damping_ratio; /* 1 */
    /* Outputs. Displacement and velocity are relative to the ground, acceleration is total: that of the ground is in it. */
    double interface_displacement[POINTS];     /* m along n, since the start */
    double interface_velocity[POINTS];         /* m/s along n */
    double interface_acceleration[POINTS];     /* m/s2 along n, mean over the step */
    double interface_acceleration_end[POINTS]; /* m/s2 along n, at the end of the step */
    double crest_displacement[2];              /* m along x and y, since the start */
    double crest_static_displacement[2];       /* m along x and y, under the hydrostatic pressure */
    /* Memory: the sway along x relative to the ground, and the ground, at the end of the last step. */
    double displacement, velocity, acceleration, ground;
} State;

static const State START = {.mass = MASS, .stiffness = STIFFNESS, .damping_ratio = DAMPING_RATIO};

static const double ADDED_MASS_INCLUDED[1] = {0.0};

/* The variables by the value references of fmu/modelDescription.xml; a new one needs a line in both. */
static const Variable VARIABLES[] = {
    INPUT(1, interface_pressure),
    INPUT(2, hydrostatic_pressure),
    INPUT(3, ground_acceleration),
    OUTPUT(10, interface_displacement),
    OUTPUT(11, interface_velocity),
    OUTPUT(12, interface_acceleration),
    OUTPUT(13, crest_displacement),
    OUTPUT(15, crest_static_displacement),
    OUTPUT(16, interface_acceleration_end),
    CONSTANT(40, X),
    CONSTANT(41, Y),
    CONSTANT(42, NORMAL_X),
    CONSTANT(43, NORMAL_Y),
    CONSTANT(44, LENGTH),
    PARAMETER(56, damping_ratio),
    CONSTANT(61, ADDED_MASS_INCLUDED),
    PARAMETER(100, mass),
    PARAMETER(101, stiffness),
};

/* Force of a pressure on the dam along x, N/m: the sum of p n_x over the face. */
static double force(const double pressure[POINTS])
{
    double sum = 0.0;
    for (int i = 0; i < POINTS; i++)
        sum += pressure[i] * LENGTH[i] * NORMAL_X[i];
    return sum;
}

/* Puts the sway into the outputs; `mean` is its total acceleration, mean over the step. */
static void show(State *s, double mean)
{
    for (int i = 0; i < POINTS; i++) {
        s->interface_displacement[i] = s->displacement * NORMAL_X[i];
        s->interface_velocity[i] = s->velocity * NORMAL_X[i];
        s->interface_acceleration[i] = mean * NORMAL_X[i];
        s->interface_acceleration_end[i] = (s->acceleration + s->ground) * NORMAL_X[i];
    }
    s->crest_displacement[0] = s->displacement;
}

/* Prepares the unit at the start time, at rest under the hydrostatic pressure, from its parameters and first inputs; it may be
 * called several times. Returns NULL, or what is wrong. */
static const char *start(State *s)
{
    if (!(s->mass > 0.0 && s->stiffness > 0.0 && s->damping_ratio >= 0.0))
        return "mass and stiffness must be above 0, damping_ratio not below";
    s->crest_static_displacement[0] = force(s->hydrostatic_pressure) / s->stiffness;
    s->displacement = s->velocity = 0.0;
    s->ground = s->ground_acceleration[0];
    s->acceleration = force(s->interface_pressure) / s->mass - s->ground;
    show(s, s->acceleration + s->ground);
    return NULL;
}

/* Takes a step of `length` (s) from `time`. The inputs are those of its end. Returns NULL, or why it failed.
 *
 * The dam sways as one body, m (a + a_ground) + c v + k u = force, by Newmark's method with the mean acceleration. */
static const char *step(State *s, double time, double length)
{
    (void)time;
    const double h = length, m = s->mass, k = s->stiffness, c = 2.0 * s->damping_ratio * sqrt(m * k);
    const double ground = s->ground_acceleration[0], before = s->acceleration + s->ground;
    const double u = s->displacement + h * s->velocity + 0.25 * h * h * s->acceleration;
    const double v = s->velocity + 0.5 * h * s->acceleration;
    const double load = force(s->interface_pressure) - m * ground;
    s->acceleration = (load - c * v - k * u) / (m + 0.5 * h * c + 0.25 * h * h * k);
    s->velocity = v + 0.5 * h * s->acceleration;
    s->displacement = u + 0.25 * h * h * s->acceleration;
    s->ground = ground;
    show(s, 0.5 * (before + s->acceleration + ground));
    return NULL;
}


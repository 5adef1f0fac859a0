/* Tables of the database as the library carries them, and as they are looked up (docs/aerodynamic-data.md). */
#ifndef GTM_UNFOLD_H
#define GTM_UNFOLD_H

#include "generated/order.h"
#include "gtm/axis.h"

/* A table as lines along one axis, each a Chebyshev polynomial c0 T0(x) + .. + c5 T5(x), or values where it is none.
   Lines follow each other by block, alpha, third axis and component. */
typedef struct {
    int blocks, alphas, places, thirds, components;
    int width;                 /* of the components in the table that is looked up */
    double scale;              /* x = place / scale */
    const double *alpha, *place;
    const unsigned char *form; /* of each line: bit k tells that c_k is not zero, or GTM_LINE_VALUES */
    const double *number;      /* of the lines, one after another: what their forms tell */
} gtm_stored_table;

/* Generated from the data file; the left aileron's table is the right one's mirror image. */
extern const gtm_stored_table gtm_basic_stored, gtm_elevator_stored, gtm_aileron_stored, gtm_rudder_stored, gtm_p_stored,
    gtm_q_stored, gtm_r_stored, gtm_omega_stored, gtm_right_spoiler_stored, gtm_tail_stored, gtm_gear_stored,
    gtm_damage_increment_stored;

/* Evaluate a table at its own places and the alphas of the look-up: [block][alpha][place][third][component].

   has_mirror_image: its mirror image about the plane of symmetry is added, that of the other aileron or of the other
   sign of the rudder (SPEC 5.2, 5.3).
   places: an axis at which it is wanted instead of its own places, linear between them; null for none. */
void gtm_unfold(const gtm_stored_table *from, int has_mirror_image, const gtm_axis *places, double *to);

/* GTM_AT_LOAD(function) has it run once when the library is loaded, or before main of a program that it is linked to. */
#ifdef _MSC_VER
#pragma section(".CRT$XCU", read)
#define GTM_AT_LOAD(function) GTM_ENTRY(function) = function;
#define GTM_ENTRY(function) __declspec(allocate(".CRT$XCU")) void (*const function##_at_load)(void)
#else
#define GTM_AT_LOAD(function) __attribute__((constructor)) void function(void);
#endif

#endif

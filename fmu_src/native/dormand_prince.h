/* Dormand and Prince's embedded Runge-Kutta pair of orders 5 and 4 with control of the step size (J. Comput. Appl.
   Math. 6, 1980; Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.4-II.5). */
#ifndef DORMAND_PRINCE_H
#define DORMAND_PRINCE_H

#include "model.h"

/* Move x[N_STATES] on by `duration` with constant u. The error of each step stays below tolerance * (size + |x|) in the
   mean square over the states. The first step tried is the whole duration, so that nothing need be remembered between
   calls. Returns 0, the fault that the derivatives have where no smaller step avoids it, or `missed` when the
   tolerance cannot be kept; x is then undefined. */
int dormand_prince(double x[], const double u[], const double values[], const double memory[], double duration,
                   double tolerance, const double size[], int missed);

#endif

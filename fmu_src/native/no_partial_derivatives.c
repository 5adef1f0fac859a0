/* A model without partial derivatives. */
#include "instance.h"

Status instance_differentiate(Instance *i, const unsigned unknowns[], size_t n_unknowns, const unsigned knowns[],
                              size_t n_knowns, const double seed[], double sensitivity[], bool is_adjoint)
{
    (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)seed, (void)sensitivity, (void)is_adjoint;
    return instance_refuse(i, "The FMU has no partial derivatives.");
}

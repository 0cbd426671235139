#pragma once

/// \file
/// Methods beyond the six schemes, each in a header of its own; docs/mis-methods.md says when which
/// one pays. gmis/mis.hpp does not include them.

#include "gmis/mis/counted_round.hpp"
#include "gmis/mis/diagnostics/counted_variance.hpp"
#include "gmis/mis/methods/adaptive_mis.hpp"
#include "gmis/mis/methods/best_groups.hpp"
#include "gmis/mis/methods/compensation.hpp"
#include "gmis/mis/methods/control_variate.hpp"
#include "gmis/mis/methods/correlation_aware.hpp"
#include "gmis/mis/methods/marginal_density.hpp"
#include "gmis/mis/methods/optimal_allocation.hpp"
#include "gmis/mis/methods/optimal_weights.hpp"
#include "gmis/mis/methods/pairwise.hpp"
#include "gmis/mis/methods/population.hpp"
#include "gmis/mis/methods/randomised_qmc.hpp"
#include "gmis/mis/methods/resampling.hpp"
#include "gmis/mis/methods/reservoir.hpp"
#include "gmis/mis/methods/scrambled_sobol.hpp"
#include "gmis/mis/methods/self_normalised.hpp"
#include "gmis/mis/methods/stochastic_mis.hpp"
#include "gmis/mis/methods/variance_aware.hpp"
#include "gmis/mis/methods/weight_heuristic.hpp"

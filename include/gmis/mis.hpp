#pragma once

/// \file
/// Multiple importance sampling: proposals, the fifteen pairs of selection and weighting,
/// estimates, heuristics. The exact variances are not here but in gmis/mis/diagnostics.hpp.

#include "gmis/mis/arguments.hpp"
#include "gmis/mis/diagnostics/coverage.hpp"
#include "gmis/mis/estimate.hpp"
#include "gmis/mis/heuristic.hpp"
#include "gmis/mis/multi_sample.hpp"
#include "gmis/mis/partial_mixture.hpp"
#include "gmis/mis/proposal.hpp"
#include "gmis/mis/proposal_set.hpp"
#include "gmis/mis/round.hpp"
#include "gmis/mis/sample_allocation.hpp"
#include "gmis/mis/scheme.hpp"

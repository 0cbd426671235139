#pragma once

/// \file
/// Exact means and variances of the six schemes by quadrature, beside which measured ones can be
/// put; checks of the quadrature; and the choice of a scheme from a pilot. For study and tests,
/// before an estimate: no estimate uses any of this, and gmis/mis.hpp does not include it.

#include "gmis/mis/diagnostics/averaged_variance.hpp"
#include "gmis/mis/diagnostics/best_scheme.hpp"
#include "gmis/mis/diagnostics/check_problem.hpp"
#include "gmis/mis/diagnostics/counted_variance.hpp"
#include "gmis/mis/diagnostics/exact_variance.hpp"
#include "gmis/mis/diagnostics/quadrature.hpp"
#include "gmis/mis/diagnostics/tabulated_problem.hpp"

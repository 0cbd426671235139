#pragma once

/// \file
/// The results of a rendering: images with their errors, logs, and the times to an error that
/// follow from them.

#include "gmis/result/batch_means.hpp"
#include "gmis/result/budget.hpp"
#include "gmis/result/convergence_log.hpp"
#include "gmis/result/counters.hpp"
#include "gmis/result/error_estimate.hpp"
#include "gmis/result/error_fit.hpp"
#include "gmis/result/film.hpp"
#include "gmis/result/image_error.hpp"
#include "gmis/result/merging_bias.hpp"
#include "gmis/result/rejection_limit.hpp"
#include "gmis/result/sobol_gain.hpp"
#include "gmis/result/time_to_error.hpp"

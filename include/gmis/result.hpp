#pragma once

/// \file
/// What a rendering leaves: images with their errors, logs, and what they say about the time it
/// takes.

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

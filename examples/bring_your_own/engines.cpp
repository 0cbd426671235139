#include "adapter.hpp"

#include <gmis/render.hpp>

// Compiles the engines of the adapter's scene, for all files that declare them by
// GMIS_DECLARE_ENGINES(adapter::Scene).

GMIS_DEFINE_ENGINES(adapter::Scene);

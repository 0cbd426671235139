#include "support/progressive_render.hpp"

template class gmis::RenderRun<gmis::tools::SceneSpectrum>;

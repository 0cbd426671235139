#include "support/progressive_render.hpp"

namespace gmis {

template class Render<tools::SceneType>;

}  // namespace gmis

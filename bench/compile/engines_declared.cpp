// Render over an adapter whose engines another file defines (./run bench compile).

#include "bring_your_own/adapter.hpp"

#include <gmis/render.hpp>

GMIS_DECLARE_ENGINES(adapter::Scene);

#include "bring_your_own/main.cpp"

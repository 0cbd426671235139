#pragma once

#include <memory>

#include "io/Scene.hpp"
#include "primitives/EmbreeUtil.hpp"
#include "renderer/TraceableScene.hpp"
#include "thread/ThreadUtils.hpp"

namespace adapter {

/// One of Tungsten's scenes, ready to be rendered on one thread.
struct Loaded {
  explicit Loaded(const char* file) {
    Tungsten::EmbreeUtil::initDevice();
    Tungsten::ThreadUtils::startThreads(1);
    scene.reset(Tungsten::Scene::load(Tungsten::Path(file)));
    scene->loadResources();
    traceable.reset(scene->makeTraceable());
  }
  std::unique_ptr<Tungsten::Scene> scene;
  std::unique_ptr<Tungsten::TraceableScene> traceable;
};

}  // namespace adapter

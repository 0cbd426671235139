#include <cstdio>
#include <gmis/render.hpp>
#include <gmis/render/thread_executor.hpp>

#include "adapter.hpp"
#include "world.hpp"

// A renderer of another style renders with gmis: its scene is rendered to picture.pfm. check.cpp
// checks the adapter.

int main() {
  const theirs::World world = theirs::make_world(64, 48);
  const adapter::Scene scene(world);

  gmis::ThreadExecutor threads;
  const auto request = gmis::automatic_request(scene, {.iterations = 32}, threads.thread_count());
  const gmis::RenderResult result = gmis::Render(scene, request).run(threads);
  std::printf("mean %.4f, relative error %.4f\n", result.estimate.mean,
              result.error ? result.error->relative_error : 0.0);

  std::FILE* file = std::fopen("picture.pfm", "wb");  // rows of a PFM file run from bottom to top
  if (file == nullptr) return 1;
  const gmis::Picture& picture = result.picture;
  std::fprintf(file, "PF\n%d %d\n-1\n", picture.size.x, picture.size.y);
  for (int y = picture.size.y - 1; y >= 0; --y)
    std::fwrite(&picture.values[static_cast<std::size_t>(3 * y * picture.size.x)], sizeof(float),
                static_cast<std::size_t>(3 * picture.size.x), file);
  return std::fclose(file) == 0 && result.is_trustworthy ? 0 : 1;
}

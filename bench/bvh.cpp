// The built-in tree beside Embree 3 (single rays, ROBUST) on five meshes: rays a second, seconds to
// build, bytes while building. Both are timed in this process, in turns. Without Embree only the
// built-in tree is shown. Prints a table in Markdown; benches/bvh.py puts it into a document.
//
// Usage: bvh [--scale S] [--size PIXELS] [--rounds N] [--threads N] [--mesh NAME]

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "bvh/meshes.hpp"
#include "bvh/rays.hpp"
#include "gmis/core/concepts.hpp"
#include "support/counted_memory.hpp"
#if GMIS_HAS_EMBREE
#include "bvh/embree.hpp"
#endif

namespace {

using namespace bench_bvh;
using gmis::scene::BvhBuilder;

struct Options {
  double scale = 1;
  int size = 512;
  int rounds = 5;
  int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  std::string_view mesh;
};

/// A number of threads that take the next piece of work from a counter.
class Threads {
 public:
  explicit Threads(int count) : count_(count) {}
  template <class Work>
  void parallel_for(std::size_t count, Work&& work) const {
    std::atomic<std::size_t> next{0};
    const auto run = [&] {
      for (std::size_t i = next++; i < count; i = next++) work(i);
    };
    std::vector<std::thread> helpers;
    for (int i = 1; i < count_ && static_cast<std::size_t>(i) < count; ++i) helpers.emplace_back(run);
    run();
    for (std::thread& helper : helpers) helper.join();
  }

 private:
  int count_;
};

template <class Work>
double seconds(Work&& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

constexpr std::size_t chunk_size = 1024;  // a few tenths of a millisecond: most are not interrupted

/// The sum over all chunks of the shortest time that each took in any round.
class ShortestTimes {
 public:
  void add(std::size_t chunk, double time) {
    if (chunk >= times_.size()) times_.resize(chunk + 1, std::numeric_limits<double>::infinity());
    times_[chunk] = std::min(times_[chunk], time);
  }
  [[nodiscard]] double total() const {
    double sum = 0;
    for (const double time : times_) sum += time;
    return sum;
  }

 private:
  std::vector<double> times_;
};

/// The distances (closest hits), or 0 and 1 (blocked).
template <class Tree>
void trace(const Tree& tree, const RaySet& set, std::size_t begin, std::size_t end, std::vector<float>& results) {
  if (set.any_hit)
    for (std::size_t i = begin; i < end; ++i) results[i] = tree.is_blocked(set.rays[i]) ? 1.0F : 0.0F;
  else
    for (std::size_t i = begin; i < end; ++i) results[i] = tree.closest(set.rays[i]);
}

struct BuiltIn {
  const gmis::scene::Bvh<float>* bvh;
  [[nodiscard]] float closest(const Ray<float>& ray) const { return bvh->closest(ray).t; }
  [[nodiscard]] bool is_blocked(const Ray<float>& ray) const { return bvh->is_blocked(ray); }
};

/// A figure of the built-in tree and, where there is Embree, that over Embree's.
std::string beside_embree(const char* format, double own, double other) {
  char text[64];
  std::snprintf(text, sizeof text, format, own);
  std::string cell = text;
  if (other > 0) {
    std::snprintf(text, sizeof text, " (%.2f)", own / other);
    cell += text;
  }
  return cell;
}

void print_row(const std::vector<std::string>& cells) {
  for (const std::string& cell : cells) std::printf("| %s ", cell.c_str());
  std::printf("|\n");
  std::fflush(stdout);
}

/// Prints the row of a mesh. Returns for how many rays the two trees disagree.
std::size_t compare(const Mesh& mesh, const Options& options, const std::vector<int>& thread_counts) {
  const auto corners = mesh.corners();
  const auto count = static_cast<double>(corners.size());
  std::vector<std::string> cells{mesh.name, std::to_string(corners.size())};

  gmis::scene::BuiltBvh<float> built;
#if GMIS_HAS_EMBREE
  std::unique_ptr<EmbreeScene> embree;
#endif
  std::size_t bytes = 0;
  for (const int threads : thread_counts) {
    double own = std::numeric_limits<double>::infinity(), other = own;
    for (int round = 0; round < options.rounds; ++round) {
      built = {};
      const std::size_t before = counted_memory::now;
      counted_memory::peak = before;
      Threads executor(threads);
      own = std::min(own, seconds([&] { built = BvhBuilder<float>(corners, {}).build(executor); }));
      bytes = std::max(bytes, counted_memory::peak - before);
#if GMIS_HAS_EMBREE
      embree = std::make_unique<EmbreeScene>(mesh, threads);
      other = std::min(other, seconds([&] { embree->build(); }));
#endif
    }
    cells.push_back(beside_embree("%.2f", own, std::isfinite(other) ? other : 0));
  }
  cells.push_back(beside_embree("%.1f", static_cast<double>(bytes) / count, 0));
  cells.push_back(beside_embree("%.1f", static_cast<double>(built.bvh.byte_count()) / count, 0));

  const BuiltIn own{&built.bvh};
  std::size_t differences = 0;
  for (const RaySet& set : make_rays(mesh, built, options.size)) {
    std::vector<float> own_results(set.rays.size()), other_results(set.rays.size());
    ShortestTimes own_times, other_times;
    for (int round = 0; round < options.rounds; ++round)
      for (std::size_t chunk = 0; chunk * chunk_size < set.rays.size(); ++chunk) {
        const std::size_t begin = chunk * chunk_size, end = std::min(set.rays.size(), begin + chunk_size);
        own_times.add(chunk, seconds([&] { trace(own, set, begin, end, own_results); }));
#if GMIS_HAS_EMBREE
        other_times.add(chunk, seconds([&] { trace(*embree, set, begin, end, other_results); }));
#endif
      }
    const auto rate = [&](const ShortestTimes& times) {
      return static_cast<double>(set.rays.size()) / times.total() / 1e6;
    };
#if GMIS_HAS_EMBREE
    for (std::size_t i = 0; i < set.rays.size(); ++i) {
      const float a = own_results[i], b = other_results[i];
      differences += a == b || std::abs(a - b) <= 1e-4F * (1 + std::abs(b)) ? 0U : 1U;
    }
    cells.push_back(beside_embree("%.2f", rate(own_times), rate(other_times)));
#else
    cells.push_back(beside_embree("%.2f", rate(own_times), 0));
#endif
  }
  print_row(cells);
  return differences;
}

int usage() {
  std::fprintf(stderr, "Usage: bvh [--scale S] [--size PIXELS] [--rounds N] [--threads N] [--mesh NAME]\n");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; i += 2) {
    const std::string_view name = argv[i];
    if (i + 1 == argc) return usage();
    const char* const value = argv[i + 1];
    if (name == "--scale")
      options.scale = std::atof(value);
    else if (name == "--size")
      options.size = std::atoi(value);
    else if (name == "--rounds")
      options.rounds = std::atoi(value);
    else if (name == "--threads")
      options.threads = std::atoi(value);
    else if (name == "--mesh")
      options.mesh = value;
    else
      return usage();
  }
  if (!(options.scale > 0) || options.size < 1 || options.rounds < 1 || options.threads < 1) return usage();
  std::vector<int> thread_counts{1};
  if (options.threads > 1) thread_counts.push_back(options.threads);
  std::vector<std::string> head{"mesh", "triangles"};
  for (const int threads : thread_counts) head.push_back("built by " + std::to_string(threads) + ", s");
  for (const char* title : {"bytes while building", "bytes kept", "camera", "diffuse", "shadow"})
    head.emplace_back(title);
  print_row(head);
  print_row(std::vector<std::string>(head.size(), "---"));
  std::size_t differences = 0;
  for (const auto& make : all_meshes()) {
    const Mesh mesh = make(options.scale);
    if (options.mesh.empty() || mesh.name.find(options.mesh) != std::string::npos)
      differences += compare(mesh, options, thread_counts);
  }
#if GMIS_HAS_EMBREE
  std::printf("\nIn brackets: over Embree 3. Results of %zu rays differ.\n", differences);
#else
  std::printf("\nWithout Embree.\n");
#endif
}

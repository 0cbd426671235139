#include "support/replay_text.hpp"

#include <cstdarg>
#include <cstdio>

#include "support/diagnostics.hpp"
#include "support/plan_text.hpp"

namespace gmis::tools {
namespace {

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

std::string number(double value) {
  return format("%.9g", value);
}

std::string triple(const glm::vec3& v) {
  return number(v.x) + " " + number(v.y) + " " + number(v.z);
}

std::string pixel_text(std::uint32_t pixel, glm::ivec2 resolution) {
  const auto width = static_cast<std::uint32_t>(resolution.x);
  return format("%u,%u", pixel % width, pixel / width);
}

std::string where(const PathName& path, glm::ivec2 resolution) {
  return path.kind == PathKind::light ? "a light tree" : "pixel " + pixel_text(path.number, resolution);
}

std::string vertex_text(const ReplayedVertex<glm::vec3>& vertex, std::size_t place) {
  std::string text = format("vertex %zu    ", place);
  if (vertex.parent == ReplayedVertex<glm::vec3>::none)
    return text + "start at " + triple(vertex.point.position) + ", sends " + triple(vertex.throughput);
  text += format("from %zu, depth %d, ", vertex.parent, vertex.depth);
  text += vertex.is_at_infinity ? "leaves the scene along " + triple(-vertex.to_prev)
                                : "at " + triple(vertex.point.position);
  text += "\n  throughput     " + triple(vertex.throughput);
  if (!vertex.is_at_infinity) {
    text += "\n  normal         " + triple(vertex.point.geometric_normal);
    if (vertex.point.shading_normal != vertex.point.geometric_normal)
      text += ", of shading " + triple(vertex.point.shading_normal);
  }
  text += format("\n  densities      at vertex %zu", vertex.parent) + (vertex.is_delta ? ", a delta event" : "") +
          ": forward " + number(vertex.forward) + ", reverse " + number(vertex.reverse);
  if (!vertex.is_at_infinity) text += "; of this vertex per area " + number(vertex.density);
  if (vertex.weights)
    text += "\n  partial weight shared " + number(vertex.weights->shared.to_double()) + ", chain " +
            number(vertex.weights->chain.to_double());
  return text;
}

std::string contribution_text(const ReplayedContribution<glm::vec3>& made, const ReplayedPath<glm::vec3>& path,
                              glm::ivec2 resolution) {
  const auto& contribution = made.contribution;
  std::string text = "  " + text_of(contribution.id);
  if (path.name.kind == PathKind::light) text += " to pixel " + pixel_text(contribution.pixel, resolution);
  text += ": value " + triple(contribution.value) + ", weight " + number(contribution.weight) + ", adds " +
          triple(contribution.value * contribution.weight);
  if (made.light_vertex)
    text += "; light vertex at depth " + std::to_string(made.light_vertex->second) + " of " +
            text_of(PathName{PathKind::light, path.name.iteration, made.light_vertex->first});
  if (made.position) text += "; at " + triple(*made.position);
  if (made.rejected) text += std::string("; REJECTED: ") + text_of(*made.rejected);
  return text;
}

}  // namespace

std::string text_of(const PathName& path) {
  return std::to_string(path.iteration) + (path.kind == PathKind::light ? ":light:" : ":") +
         std::to_string(path.number);
}

const char* text_of(RejectionCause cause) {
  constexpr const char* texts[] = {"not finite", "negative", "of density zero"};
  return texts[static_cast<std::size_t>(cause)];
}

std::string text_of(const TechniqueId& id) {
  std::string text = format("%s s%d t%d", name_of(id.technique), id.s, id.t);
  if (id.path_class != PathClass::unclassified) text += " " + std::string(gmis::name_of(id.path_class));
  return text;
}

std::string rejected_text(std::span<const RejectedPath> paths, glm::ivec2 resolution) {
  std::string text;
  for (const RejectedPath& rejected : paths)
    text += format("rejected %s (%s): %u, the first %s by %s\n", text_of(rejected.path).c_str(),
                   where(rejected.path, resolution).c_str(), rejected.count, text_of(rejected.cause),
                   rejected.technique ? text_of(*rejected.technique).c_str() : "no technique");
  return text;
}

PathName path_of(const PathChoice& choice, const RenderRequest& request, glm::ivec2 resolution) {
  PathName path{choice.is_light ? PathKind::light : PathKind::camera, choice.iteration, choice.number};
  const auto width = static_cast<std::uint32_t>(resolution.x), height = static_cast<std::uint32_t>(resolution.y);
  if (choice.is_light) return path;
  std::uint32_t x = 0, y = 0;
  if (choice.pixel) {
    x = (*choice.pixel)[0];
    y = (*choice.pixel)[1];
  } else {
    x = choice.number % width;
    y = choice.number / width;
  }
  const PixelBounds part = request.crop.value_or(PixelBounds{{0, 0}, resolution});
  if (x >= width || y >= height || static_cast<int>(x) < part.lower.x || static_cast<int>(y) < part.lower.y ||
      static_cast<int>(x) >= part.upper.x || static_cast<int>(y) >= part.upper.y)
    throw InputError(format("--replay: there is no such pixel: %d,%d to %d,%d are rendered, of a picture of %ux%u",
                            part.lower.x, part.lower.y, part.upper.x - 1, part.upper.y - 1, width, height));
  path.number = y * width + x;
  return path;
}

std::string replay_text(const ReplayedPath<glm::vec3>& path, const RenderRequest& request, glm::ivec2 resolution) {
  std::string text = "path        " + text_of(path.name) + ", " + where(path.name, resolution) + "\n";
  text += "seed        " + std::to_string(request.settings.seed) + "\n";
  if (path.radius > 0) text += "radius      " + number(path.radius) + "\n";
  text += format("counts      connections %d, light vertices a tree ", path.counts.connections) +
          (path.vertices_per_tree > 0 ? number(path.vertices_per_tree) : "not measured") + "\n";
  std::size_t next = 0, next_zero = 0, rejected = 0;
  if (path.vertices.empty()) text += "nothing starts here\n";
  for (std::size_t i = 0; i < path.vertices.size(); ++i) {
    text += vertex_text(path.vertices[i], i) + "\n";
    for (; next < path.contributions.size() && path.contributions[next].vertex == i; ++next) {
      const auto& made = path.contributions[next];
      text += contribution_text(made, path, resolution) + "\n";
      if (made.rejected) ++rejected;
    }
    for (; next_zero < path.zero_densities.size() && path.zero_densities[next_zero].vertex == i; ++next_zero) {
      const auto& zero = path.zero_densities[next_zero];
      text += "  REJECTED: " + (zero.technique ? text_of(*zero.technique) + ", " : "the subpath ends, ") +
              text_of(RejectionCause::zero_pdf) + "\n";
    }
  }
  text += format("sum         %zu contributions, %zu of them rejected", path.contributions.size(), rejected);
  if (path.name.kind == PathKind::camera) text += "; adds to its pixel " + triple(path.pixel_sum);
  // All that was left out is said above, but for a sum that is not finite although each of its
  // terms is.
  if (path.counters.rejected() > rejected + path.zero_densities.size())
    text += std::string("; REJECTED: ") + text_of(RejectionCause::non_finite);
  return text + "\n";
}

}  // namespace gmis::tools

#include "support/gltf/nodes.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <set>

namespace gmis::tools::gltf {
namespace {

std::vector<std::size_t> indices_in(const Document& document, const Json& list, const std::string& what) {
  std::vector<std::size_t> result;
  if (list.is_null()) return result;
  if (!list.is_array()) throw document.error(what + " is no list");
  for (const Json& one : list) {
    const double value = one.is_number() ? one.get<double>() : -1;
    if (!(value >= 0 && value < static_cast<double>(document.count("nodes")) && value == std::floor(value)))
      throw document.error(what + " names a node that is not there");
    result.push_back(static_cast<std::size_t>(value));
  }
  return result;
}

}  // namespace

std::vector<double> sampled(const std::vector<double>& times, const std::vector<double>& values,
                            const std::string& interpolation, double seconds, bool is_rotation) {
  const bool is_cubic = interpolation == "CUBICSPLINE";
  const std::size_t parts = is_cubic ? 3 : 1;
  if (times.empty() || values.size() % (times.size() * parts) != 0) return {};
  const std::size_t width = values.size() / (times.size() * parts);
  const auto key = [&](std::size_t i, std::size_t part) {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>((i * parts + part) * width);
    return std::vector<double>(first, first + static_cast<std::ptrdiff_t>(width));
  };
  const std::size_t middle = is_cubic ? 1 : 0;
  const auto after = std::upper_bound(times.begin(), times.end(), seconds);
  if (after == times.begin()) return key(0, middle);
  if (after == times.end()) return key(times.size() - 1, middle);
  const auto next = static_cast<std::size_t>(after - times.begin()), last = next - 1;
  if (interpolation == "STEP") return key(last, middle);
  const double length = times[next] - times[last], t = length > 0 ? (seconds - times[last]) / length : 0;
  const std::vector<double> a = key(last, middle), b = key(next, middle);
  std::vector<double> result(width);
  if (is_cubic) {  // Hermite's, with an in-tangent, a value and an out-tangent at each key
    const std::vector<double> out = key(last, 2), in = key(next, 0);
    const double t2 = t * t, t3 = t2 * t;
    for (std::size_t i = 0; i < width; ++i)
      result[i] = (2 * t3 - 3 * t2 + 1) * a[i] + length * (t3 - 2 * t2 + t) * out[i] + (3 * t2 - 2 * t3) * b[i] +
                  length * (t3 - t2) * in[i];
  } else if (is_rotation && width == 4) {
    const glm::dquat q = glm::slerp(glm::dquat(a[3], a[0], a[1], a[2]), glm::dquat(b[3], b[0], b[1], b[2]), t);
    result = {q.x, q.y, q.z, q.w};
  } else {
    for (std::size_t i = 0; i < width; ++i) result[i] = a[i] * (1 - t) + b[i] * t;
  }
  return result;
}

Nodes::Nodes(const Document& document, std::optional<double> seconds) : document_(document) {
  const std::size_t count = document.count("nodes");
  document.budget().take(count, 600, "the nodes", document.where());
  parents_.resize(count);
  children_.resize(count);
  weights_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Json& node = document.entry("nodes", i);
    Local local;
    const auto t = document.numbers(node, "translation", {0, 0, 0}), s = document.numbers(node, "scale", {1, 1, 1});
    const auto r = document.numbers(node, "rotation", {0, 0, 0, 1});
    local.translation = {t[0], t[1], t[2]};
    local.scale = {s[0], s[1], s[2]};
    local.rotation = glm::dquat(r[3], r[0], r[1], r[2]);
    if (!Document::member(node, "matrix").is_null()) {
      const auto m = document.numbers(node, "matrix", std::vector<double>(16));
      local.matrix.emplace();
      for (int k = 0; k < 16; ++k) (*local.matrix)[k / 4][k % 4] = m[static_cast<std::size_t>(k)];
    }
    locals_.push_back(local);
    children_[i] = indices_in(document, Document::member(node, "children"), document.named("node", node, i));
    for (const std::size_t child : children_[i]) {
      if (parents_[child])
        throw document.error("node " + std::to_string(child) + " has two parents: glTF's nodes are trees");
      parents_[child] = i;
    }
  }
  if (seconds && document.count("animations") > 0) animate(document.entry("animations", 0), *seconds);
  place_all();
  show_scene();
}

void Nodes::animate(const Json& animation, double seconds) {
  const Json& samplers = Document::member(animation, "samplers");
  for (const Json& channel : Document::member(animation, "channels")) {
    const Json& target = Document::member(channel, "target");
    const auto node = document_.index(target, "node"), number = document_.index(channel, "sampler");
    if (!node) continue;
    if (*node >= locals_.size() || !number || !samplers.is_array() || *number >= samplers.size())
      throw document_.error("an animation refers to a node or a sampler that is not there");
    const Json& sampler = samplers[*number];
    const auto input = document_.index(sampler, "input"), output = document_.index(sampler, "output");
    if (!input || !output) throw document_.error("a sampler of an animation lacks its keys");
    const std::string path = document_.text(target, "path");
    const std::vector<double> value =
        sampled(document_.accessor(*input, 1, "an animation"),
                document_.accessor(*output, document_.components_of(*output, "an animation")),
                document_.text(sampler, "interpolation", "LINEAR"), seconds, path == "rotation");
    Local& local = locals_[*node];
    if (path == "translation" && value.size() == 3) local.translation = {value[0], value[1], value[2]};
    if (path == "scale" && value.size() == 3) local.scale = {value[0], value[1], value[2]};
    if (path == "rotation" && value.size() == 4) local.rotation = glm::dquat(value[3], value[0], value[1], value[2]);
    if (path == "weights") weights_[*node] = value;
    if (path != "weights") local.matrix.reset();
  }
}

void Nodes::place_all() {
  world_.assign(locals_.size(), glm::dmat4(1));
  is_hidden_.assign(locals_.size(), false);
  std::vector<std::size_t> open;
  std::vector<bool> is_placed(locals_.size(), false);
  for (std::size_t i = 0; i < locals_.size(); ++i)
    if (!parents_[i]) open.push_back(i);
  while (!open.empty()) {
    const std::size_t node = open.back();
    open.pop_back();
    is_placed[node] = true;
    const Local& local = locals_[node];
    glm::dmat4 m = local.matrix.value_or(glm::dmat4(1));
    if (!local.matrix) {
      const double length = glm::length(local.rotation);
      if (length > 0) m = glm::mat4_cast(local.rotation / length);
      for (int axis = 0; axis < 3; ++axis) m[axis] *= local.scale[axis];
      m[3] = glm::dvec4(local.translation, 1);
    }
    world_[node] = parents_[node] ? world_[*parents_[node]] * m : m;
    const Json& extension = Document::extension(document_.entry("nodes", node), "KHR_node_visibility");
    const Json& visible = Document::member(extension, "visible");
    is_hidden_[node] =
        (visible.is_boolean() && !visible.get<bool>()) || (parents_[node] && is_hidden_[*parents_[node]]);
    open.insert(open.end(), children_[node].begin(), children_[node].end());
  }
  const auto lost = std::find(is_placed.begin(), is_placed.end(), false);
  if (lost == is_placed.end()) return;
  // No root leads to it: the way up from there ends in a circle.
  auto node = static_cast<std::size_t>(lost - is_placed.begin());
  while (!is_placed[node]) {
    is_placed[node] = true;
    node = *parents_[node];
  }
  throw document_.error(document_.named("node", document_.entry("nodes", node), node) +
                        " is its own ancestor: take it out of the \"children\" below it");
}

void Nodes::show_scene() {
  std::vector<std::size_t> open;
  if (document_.count("scenes") > 0) {
    const Json& scene = document_.entry("scenes", document_.index(document_.root(), "scene").value_or(0));
    open = indices_in(document_, Document::member(scene, "nodes"), "the scene");
  } else {  // a library of nodes: all of it
    for (std::size_t i = 0; i < locals_.size(); ++i)
      if (!parents_[i]) open.push_back(i);
  }
  std::reverse(open.begin(), open.end());
  std::vector<bool> is_shown(locals_.size(), false);
  while (!open.empty()) {
    const std::size_t node = open.back();
    open.pop_back();
    if (is_shown[node]) continue;
    is_shown[node] = true;
    shown_.push_back(node);
    open.insert(open.end(), children_[node].rbegin(), children_[node].rend());
  }
}

}  // namespace gmis::tools::gltf

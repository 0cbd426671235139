#include "support/report/plot.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

namespace gmis::tools {

namespace {

// Colours that gnuplot is given to be found again in what it writes.
constexpr const char* axis_colour = "#0A0B0C";

std::string series_colour(std::size_t index) {
  char buffer[16];
  std::snprintf(buffer, sizeof buffer, "#0A0C%02X", static_cast<unsigned>(index + 1));
  return buffer;
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

/// A colour as gnuplot's SVG spells it: rgb( 10,  11,  12).
std::string as_svg(const std::string& colour) {
  const auto part = [&](std::size_t at) { return std::stoi(colour.substr(at, 2), nullptr, 16); };
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "rgb(%3d, %3d, %3d)", part(1), part(3), part(5));
  return buffer;
}

/// gnuplot's data blocks, one per integrator.
std::string data_of(const SceneRecord& scene) {
  std::ostringstream text;
  for (std::size_t i = 0; i < scene.contenders.size(); ++i) {
    text << "$d" << i << " << END\n";
    for (const BandPoint& point : band_of(scene.contenders[i].courses(), 64))
      text << point.seconds << ' ' << 100 * point.lowest << ' ' << 100 * point.mean << ' ' << 100 * point.highest
           << '\n';
    text << "END\n";
  }
  return text.str();
}

/// Both axes begin and end at a tick that has its number. A time of many decades has numbers at the
/// decades alone.
std::string ranges_and_ticks_of(const SceneRecord& scene) {
  double least[2] = {1e300, 1e300}, most[2] = {0, 0};
  for (const ContenderRecord& contender : scene.contenders)
    for (const BandPoint& point : band_of(contender.courses(), 64)) {
      const double values[2][2] = {{point.seconds, point.seconds}, {100 * point.lowest, 100 * point.highest}};
      for (int axis = 0; axis < 2; ++axis) {
        least[axis] = std::min(least[axis], values[axis][0]);
        most[axis] = std::max(most[axis], values[axis][1]);
      }
    }
  std::ostringstream text;
  for (int axis = 0; axis < 2; ++axis) {
    constexpr double most_in_full = 300;
    const bool is_wide = axis == 0 && most[0] > most_in_full * least[0];
    const double first = is_wide ? std::pow(10.0, std::floor(std::log10(least[0]))) : round_below(least[axis]);
    const char name = "xy"[axis];
    if (most[axis] > 0) text << "set " << name << "range [" << first << ':' << round_above(most[axis]) << "]\n";
    text << "set " << name << "tics add (";
    const char* separator = "";
    for (double tick = 1e-4; tick < 2e4; tick = is_wide ? 10 * tick : round_above(1.5 * tick)) {
      text << separator << tick;
      separator = ", ";
    }
    text << ")\n";
  }
  return text.str();
}

std::string script_of(const SceneRecord& scene, const std::filesystem::path& output) {
  std::ostringstream text;
  text << data_of(scene);
  text << "set terminal svg size 560,380 dynamic font 'sans-serif,15' linewidth 1.1\nset output '" << output.string()
       << "'\nset logscale xy\n"
       << ranges_and_ticks_of(scene) << "set border 3 lc rgb '" << axis_colour << "'\nset tics nomirror textcolor rgb '"
       << axis_colour << "'\nset format x '%g'\nset format y '%g %%'\n";
  text << "set xlabel 'processor seconds' textcolor rgb '" << axis_colour
       << "'\nset ylabel 'relative error' textcolor rgb '" << axis_colour << "'\nset grid x y lc rgb '" << axis_colour
       << "' lw 0.4 dt 3\nset key top right textcolor rgb '" << axis_colour << "' samplen 2\nset samples 2\nplot ";
  const char* separator = "";
  for (std::size_t i = 0; i < scene.contenders.size(); ++i) {
    if (band_of(scene.contenders[i].courses(), 2).empty()) continue;
    text << separator;
    if (scene.contenders[i].runs.size() > 1)
      text << "$d" << i << " using 1:2:4 with filledcurves fs transparent solid 0.18 noborder lc rgb '"
           << series_colour(i) << "' notitle, ";
    text << "$d" << i << " using 1:3 with lines lw 2 lc rgb '" << series_colour(i) << "' title '"
         << scene.contenders[i].name << "'";
    separator = ", ";
  }
  text << "\n";
  return text.str();
}

}  // namespace

bool has_gnuplot() {
  return std::system("gnuplot --version >/dev/null 2>&1") == 0;
}

std::string error_plot_svg(const SceneRecord& scene, const std::filesystem::path& folder) {
  bool has_curves = false;
  for (const ContenderRecord& contender : scene.contenders)
    has_curves = has_curves || !band_of(contender.courses(), 2).empty();
  if (!has_curves) return {};
  const auto script = folder / "plot.gnuplot.tmp", output = folder / "plot.svg.tmp";
  std::ofstream(script) << script_of(scene, output);
  const int status = std::system(("gnuplot '" + script.string() + "' >/dev/null 2>&1 </dev/null").c_str());
  std::string svg;
  {
    std::ifstream stream(output, std::ios::binary);
    svg.assign(std::istreambuf_iterator<char>(stream), {});
  }
  std::error_code ignored;
  std::filesystem::remove(script, ignored);
  std::filesystem::remove(output, ignored);
  const std::size_t begin = svg.find("<svg");
  if (status != 0 || begin == std::string::npos) return {};
  svg.erase(0, begin);
  replace_all(svg, as_svg(axis_colour), "var(--axis)");
  for (std::size_t i = 0; i < scene.contenders.size(); ++i)
    replace_all(svg, as_svg(series_colour(i)), "var(--series-" + std::to_string(i + 1) + ")");
  // Several of these stand in one page: what they refer to inside themselves must be their own.
  replace_all(svg, "id=\"", "id=\"" + scene.name + "_");
  replace_all(svg, "url(#", "url(#" + scene.name + "_");
  replace_all(svg, "href='#", "href='#" + scene.name + "_");
  replace_all(svg, "id='", "id='" + scene.name + "_");
  return svg;
}

std::string error_figure_svg(const std::vector<SceneRecord>& scenes, const std::filesystem::path& folder) {
  constexpr int width = 560, height = 380, title = 34, across = 2;
  std::ostringstream parts;
  int count = 0;
  for (const SceneRecord& scene : scenes) {
    const std::string plot = error_plot_svg(scene, folder);
    if (plot.empty()) continue;
    const int x = count % across * width, y = count / across * (height + title);
    parts << "<text class=\"title\" x=\"" << x + width / 2 << "\" y=\"" << y + title - 8 << "\">" << scene.name
          << "</text>\n<g transform=\"translate(" << x << ',' << y + title << ")\">\n<svg width=\"" << width
          << "\" height=\"" << height << "\"" << plot.substr(4) << "</g>\n";
    ++count;
  }
  if (count == 0) return {};
  const int columns = std::min(count, across), rows = (count + across - 1) / across;
  std::ostringstream svg;
  svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" viewBox=\"0 0 "
      << columns * width << ' ' << rows * (height + title) << "\">\n"
      << "<style>svg{--axis:#57524c;--series-1:#c2410c;--series-2:#0e7490;--series-3:#6d28d9;--series-4:#4d7c0f;"
         "--series-5:#be185d}text{font-family:system-ui,sans-serif;fill:var(--axis)}"
         ".title{font-size:17px;font-weight:600;text-anchor:middle}"
         "@media(prefers-color-scheme:dark){svg{--axis:#a39c94;--series-1:#fb923c;--series-2:#22d3ee;"
         "--series-3:#a78bfa;--series-4:#a3e635;--series-5:#f472b6}}</style>\n"
      << parts.str() << "</svg>\n";
  return svg.str();
}

}  // namespace gmis::tools

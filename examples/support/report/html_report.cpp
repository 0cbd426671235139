#include "support/report/html_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/diagnostics.hpp"
#include "support/image/formats.hpp"
#include "support/report/false_colour.hpp"
#include "support/report/page.hpp"
#include "support/report/plot.hpp"
#include "support/report/tables.hpp"

namespace gmis::tools {

namespace {

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '&')
      result += "&amp;";
    else if (c == '"')
      result += "&quot;";
    else
      result += c;
  }
  return result;
}

std::string base64_of(const std::vector<std::uint8_t>& bytes) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < count ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

/// "not reached (≈ 90 s)" in two lines: what is in brackets goes below.
std::string cell_of(const std::string& text, const std::string& heading) {
  const std::size_t bracket = text.find(" (");
  const bool is_miss = text.starts_with("not reached");
  std::string cell = "<td data-name=\"" + escaped(heading) + (is_miss ? "\" class=\"miss\"><span>" : "\"><span>");
  cell += escaped(text.substr(0, bracket));
  if (bracket != std::string::npos) {
    std::string below = text.substr(bracket + 2, text.size() - bracket - 3);
    cell += "<small>" + escaped(below) + (is_miss ? " by the fit" : "") + "</small>";
  }
  return cell + "</span></td>";
}

void add_table(std::ostream& html, const Table& table, const std::string& caption = {}) {
  if (table.rows.empty()) return;
  html << "<div class=\"table\"><table>";
  if (!caption.empty()) html << "<caption>" << escaped(caption) << "</caption>";
  html << "<thead><tr>";
  for (const std::string& heading : table.headings) html << "<th>" << escaped(heading) << "</th>";
  html << "</tr></thead><tbody>\n";
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    html << "<tr><td><i class=\"key\" style=\"background:var(--series-" << i + 1 << ")\"></i>"
         << escaped(table.rows[i][0]) << "</td>";
    for (std::size_t column = 1; column < table.rows[i].size(); ++column)
      html << cell_of(table.rows[i][column], table.headings[column]);
    html << "</tr>\n";
  }
  html << "</tbody></table></div>\n";
}

/// An image as large as all of them.
const Image& measure_of(const SceneRecord& scene) {
  return scene.reference.rgb.empty() ? scene.contenders.front().image : scene.reference;
}

/// The pictures' files, and the commands that render them again.
void add_runs(std::ostream& html, const SceneRecord& scene) {
  html << "<details class=\"runs\"><summary>Files and command lines</summary><p class=\"soft\">Each command makes the "
          "same picture again, bit by bit.</p><ul>\n";
  const auto link = [](const std::string& file) {
    return file.empty() ? std::string() : " <a href=\"" + escaped(file) + "\">" + escaped(file) + "</a>";
  };
  for (const ContenderRecord& contender : scene.contenders) {
    html << "<li><b>" << escaped(contender.name) << "</b>" << link(contender.file);
    for (const RunRecord& run : contender.runs) html << "<code>" << escaped(run.command) << "</code>";
    html << "</li>\n";
  }
  if (!scene.reference_file.empty()) html << "<li><b>reference</b>" << link(scene.reference_file) << "</li>\n";
  html << "</ul></details>\n";
}

/// Four bytes a pixel: red, green and blue over a common power of two, whose exponent plus 128 is
/// the fourth. Values that are negative or not finite become 0.
std::vector<std::uint8_t> shared_exponent(const Image& image) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(image.rgb.size() / 3 * 4);
  for (std::size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    std::array<float, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = image.rgb[i + c];
      rgb[c] = value > 0 && std::isfinite(value) ? value : 0.0F;
    }
    int exponent = 0;
    const float largest = std::max({rgb[0], rgb[1], rgb[2]});
    std::frexp(largest, &exponent);
    if (std::ldexp(largest, 8 - exponent) > 255.49F) ++exponent;
    exponent = std::clamp(exponent, -127, 127);
    for (const float value : rgb)
      bytes.push_back(static_cast<std::uint8_t>(std::min(255L, std::lround(std::ldexp(value, 8 - exponent)))));
    bytes.push_back(static_cast<std::uint8_t>(exponent + 128));
  }
  return bytes;
}

/// Errors of a picture in colours, for each measure that a reader may choose.
nlohmann::json maps_of(const ContenderRecord& contender) {
  nlohmann::json maps = nlohmann::json::object();
  const auto add = [&](const char* name, const Image& map) {
    if (!map.rgb.empty() && has_png()) maps[name] = base64_of(png_of(error_map(map)));
  };
  add("relative", contender.pixel_error);
  if (contender.picture_error) {
    add("smape", contender.picture_error->smape);
    add("flip", contender.picture_error->flip);
  }
  return maps;
}

void add_viewer(std::ostream& html, const SceneRecord& scene) {
  nlohmann::json images = nlohmann::json::array();
  std::string choices;
  const Image& shown = measure_of(scene);
  const float exposure = exposure_of(shown);
  const auto add = [&](const std::string& name, const Image& image, nlohmann::json maps) {
    if (image.rgb.empty() || image.rgb.size() != shown.rgb.size()) return;
    choices += "<option value=\"" + std::to_string(images.size()) + "\">" + escaped(name) + "</option>";
    images.push_back({{"name", name}, {"pixels", base64_of(shared_exponent(image))}, {"maps", std::move(maps)}});
  };
  for (const ContenderRecord& contender : scene.contenders) add(contender.name, contender.image, maps_of(contender));
  const std::size_t last = images.empty() ? 0 : images.size() - 1;
  add("reference", scene.reference, nlohmann::json::object());
  if (images.size() < 2) return;
  // At first the baseline beside the last integrator, or the first one if that is the baseline.
  const auto selecting = [&](std::size_t index) {
    std::string text = choices;
    const std::string value = "value=\"" + std::to_string(index) + "\"";
    const std::size_t at = text.find(value);
    return at == std::string::npos ? text : text.replace(at, value.size(), value + " selected");
  };
  const ContenderRecord* baseline = baseline_of(scene);
  const std::size_t left = baseline != nullptr ? static_cast<std::size_t>(baseline - scene.contenders.data()) : 0;
  html << "<div data-viewer><div class=\"bar\"><label>left <select data-left>" << selecting(left)
       << "</select></label><label>right <select data-right>" << selecting(last == left ? (left == 0 ? 1 : 0) : last)
       << "</select></label><label>show <select data-show><option value=\"picture\">pictures</option>"
          "<option value=\"difference\">|left − right|</option>";
  if (has_png()) {
    html << "<option value=\"relative\">relative error</option>";
    if (!scene.reference.rgb.empty())
      html << "<option value=\"smape\">SMAPE</option><option value=\"flip\">ꟻLIP</option>";
  }
  html
      << "</select></label><span><button data-out aria-label=\"smaller\">−</button> <span data-zoom>1×</span> "
         "<button data-in aria-label=\"larger\">+</button></span>"
         "<button data-flip title=\"key F\">flip</button></div>\n"
      << "<div class=\"viewer\" data-view tabindex=\"0\" style=\"aspect-ratio:" << shown.width << "/" << shown.height
      << "\"><canvas data-back></canvas><canvas class=\"clip\" data-front></canvas>"
         "<div class=\"line\" data-line></div><b class=\"l\" data-leftname></b><b class=\"r\" data-rightname></b></div>"
         "<input type=\"range\" min=\"0\" max=\"100\" step=\"0.1\" data-slider aria-label=\"left or right picture\">\n"
         "<div class=\"scale\" data-scale hidden><span>1 % and less</span><span></span><span>100 % and "
         "more</span></div>\n"
         "<label class=\"exposure\" data-exposures>exposure <input type=\"range\" min=\"-8\" max=\"8\" step=\"0.25\" "
         "value=\"0\" data-stops><output data-factor></output></label>\n"
         "<div class=\"loupe\" data-loupe hidden><canvas data-leftloupe width=\"9\" height=\"9\"></canvas>"
         "<canvas data-rightloupe width=\"9\" height=\"9\"></canvas><pre data-values></pre></div>\n"
      << "<p class=\"soft\">Point at a pixel to read its values. F flips between the two "
         "pictures, D shows their difference, E the next measure.</p>\n"
      << "<script type=\"application/json\">"
      << nlohmann::json{{"width", shown.width}, {"height", shown.height}, {"exposure", exposure}, {"images", images}}
             .dump()
      << "</script></div>\n";
}

void add_scene(std::ostream& html, const SceneRecord& scene, const std::filesystem::path& folder, bool has_plots) {
  html << "<section id=\"" << escaped(scene.name) << "\"><h2>" << escaped(scene.name) << "</h2><p class=\"soft\">"
       << escaped(scene.summary) << "; " << measure_of(scene).width << "×" << measure_of(scene).height
       << " pixels. Reference: " << escaped(scene.reference_origin) << "." << reference_warning(scene) << "</p>\n";
  add_table(html, table_of(scene));
  if (has_plots) html << "<div class=\"plot\">" << error_plot_svg(scene, folder) << "</div>\n";
  add_table(html, metrics_table_of(scene), "The pictures of the first seed, at the end");
  add_viewer(html, scene);
  add_runs(html, scene);
  html << "</section>\n";
}

constexpr const char* explanations = R"html(
<section><h2>How to read this</h2><dl>
<dt>Error</dt><dd>The square root of relMSE, the mean over pixels and channels of (x − ref)² / (ref² + 0.01): noise, merging's bias and
what a method misses altogether. The noise of the reference itself is in it too; it is told with each scene. Without a
reference the error is estimated from the spread between iterations: then it is noise only, so far as the run has seen it.</dd>
<dt>Seconds to reach an error</dt><dd>Processor seconds until the curve is below it for good: the geometric mean over the seeds, if every seed
came so far. “Not reached” is followed by what the power law fitted to the run says, for what an extrapolation is worth.</dd>
<dt>Curves</dt><dd>The line is the geometric mean over the seeds, the band goes from the lowest seed to the highest. Independent iterations of
equal variance fall with slope −½.</dd>
<dt>Efficiency</dt><dd>1 / (error² × processor seconds) at the end, relative to vcm with the same seed: 2 means as good in half the time. In
brackets the 95 % interval from the spread between seeds; one or two are too few for it.</dd>
<dt>Merging bias</dt><dd>The relative error that would be left without any noise, estimated from what a disk of half the radius would have merged; “below” where
noise hides it.</dd>
<dt>Measures</dt><dd>SMAPE: the mean of |x − ref| / (|x| + |ref| + 0.01). ꟻLIP (Andersson et al. 2020): the difference that a person
sees who flips between the two pictures on a screen with 67 pixels a degree, at the exposure that the viewer starts with; 0 is none, 100 % the
largest. Both are of the first seed's picture, and bounded: a firefly counts as one wrong pixel.</dd>
<dt>Exposure</dt><dd>A picture is shown as value × factor, cut to [0, 1], with the sRGB curve. The slider starts at the factor that brings the
brightest few per cent of the reference to white, and moves it by powers of two.</dd>
<dt>Fairness</dt><dd>One process; after every iteration the turn goes to the integrator that has had the least processor time, so that whatever
else the machine does meets all alike. Looking at the errors is not counted.</dd></dl></section>
)html";

}  // namespace

std::string html_of(const Comparison& comparison, const std::filesystem::path& folder) {
  std::ostringstream html;
  html << "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Accuracy and time</title>"
          "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><style>"
       << page::style << "</style></head><body><main>\n<h1>What accuracy costs in time</h1>\n<p class=\"soft\">"
       << escaped(comparison.limits) << "; " << escaped(comparison.settings) << "; " << escaped(comparison.machine)
       << "; gmis " << escaped(comparison.version) << ".</p>\n";
  if (!comparison.is_whole)
    html << "<p class=\"warn\">This comparison was interrupted: what is here is valid, but not all runs are "
            "whole.</p>\n";
  const bool has_plots = has_gnuplot();
  if (!has_plots) html << "<p class=\"warn\">gnuplot is not on this machine: there are no curves.</p>\n";
  if (!has_png()) html << "<p class=\"warn\">This program was built without libpng: there are no error maps.</p>\n";
  if (comparison.scenes.size() > 1) {
    html << "<nav>";
    for (const SceneRecord& scene : comparison.scenes)
      html << "<a href=\"#" << escaped(scene.name) << "\">" << escaped(scene.name) << "</a>";
    html << "</nav>\n";
  }
  for (const SceneRecord& scene : comparison.scenes) add_scene(html, scene, folder, has_plots);
  html << explanations << "</main><script>" << page::script << "</script></body></html>\n";
  return html.str();
}

}  // namespace gmis::tools

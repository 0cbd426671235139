#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

namespace gmis::tools {

/// A line of a text file, counted from 1.
struct SourcePosition {
  std::shared_ptr<const std::string> file;
  int line = 0;

  /// Line 0 is a file without lines.
  [[nodiscard]] std::string to_string() const {
    std::string text = file ? *file : "?";
    if (line > 0) text.append(1, ':').append(std::to_string(line));
    return text;
  }
};

/// Something is wrong with what the user gave us. `what()` is one line: where, what, and what to
/// change.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : std::runtime_error(message) {}
  /// A place without a file is none.
  InputError(const SourcePosition& where, const std::string& message)
      : std::runtime_error(where.file ? where.to_string() + ": " + message : message), message_(message) {
    if (where.file) where_ = where;
  }

  /// Nothing when the error is of no place in a file.
  [[nodiscard]] const std::optional<SourcePosition>& where() const { return where_; }
  /// `what()` without the place.
  [[nodiscard]] std::string message() const { return where_ ? message_ : what(); }

 private:
  std::optional<SourcePosition> where_;
  std::string message_;
};

/// A result could not be written. `what()` is one line.
class OutputError : public std::runtime_error {
 public:
  explicit OutputError(const std::string& message) : std::runtime_error(message) {}
};

enum class Severity { note, warning, error };

/// Treatment of unsupported input that changes the picture.
enum class Strictness {
  strict,   ///< it is an error, which ends the reading
  lenient,  ///< it is a warning, and a plain substitute is used
  check     ///< all of it is listed, and reading goes on to the end
};

struct Diagnostic {
  Severity severity;
  SourcePosition where;
  std::string message;

  [[nodiscard]] std::string to_string() const { return where.to_string() + ": " + name_of(severity) + message; }

 private:
  [[nodiscard]] static const char* name_of(Severity severity) {
    return severity == Severity::note ? "note: " : severity == Severity::warning ? "warning: " : "error: ";
  }
};

/// Collects what the reader has to say. The same message is kept once, at the place where it came
/// up first.
class Diagnostics {
 public:
  explicit Diagnostics(Strictness strictness = Strictness::strict) : strictness_(strictness) {}

  void note(const SourcePosition& where, std::string message) { add(Severity::note, where, std::move(message)); }
  void warning(const SourcePosition& where, std::string message) { add(Severity::warning, where, std::move(message)); }
  /// Something that changes the picture and is not understood. Throws `InputError` unless
  /// `Strictness` says otherwise; when this returns, the caller goes on with something plain in its
  /// place.
  void unsupported(const SourcePosition& where, const std::string& message) {
    if (strictness_ == Strictness::strict) throw InputError(where, message);
    add(strictness_ == Strictness::check ? Severity::error : Severity::warning, where, message);
  }
  /// An error that was caught so that reading can go on; `message` says where it is.
  void error(const SourcePosition& where, std::string message) { add(Severity::error, where, std::move(message)); }
  [[nodiscard]] bool is_check() const { return strictness_ == Strictness::check; }
  [[nodiscard]] std::size_t error_count() const {
    return static_cast<std::size_t>(std::count_if(
        all_.begin(), all_.end(), [](const Diagnostic& diagnostic) { return diagnostic.severity == Severity::error; }));
  }
  [[nodiscard]] const std::vector<Diagnostic>& all() const { return all_; }

 private:
  void add(Severity severity, const SourcePosition& where, std::string message) {
    if (seen_.insert(message).second) all_.push_back({severity, where, std::move(message)});
  }

  Strictness strictness_;
  std::vector<Diagnostic> all_;
  std::unordered_set<std::string> seen_;
};

/// The text in quotation marks, cut to a length that fits a line, with everything but printable
/// ASCII shown as `?`.
[[nodiscard]] inline std::string in_quotes(std::string_view text) {
  constexpr std::size_t longest = 48;
  std::string result = "\"";
  for (const char c : text.substr(0, longest)) result += (c >= ' ' && c < '\x7f') ? c : '?';
  if (text.size() > longest) result += "…";
  return result + "\"";
}

/// `in_quotes`, for the name of a file: the cut leaves the end of a long name.
[[nodiscard]] inline std::string file_in_quotes(std::string_view name) {
  constexpr std::size_t longest = 100;
  std::string result = name.size() > longest ? "\"…" : "\"";
  for (const char c : name.substr(name.size() > longest ? name.size() - longest : 0))
    result += (c >= ' ' && c < '\x7f') ? c : '?';
  return result + "\"";
}

}  // namespace gmis::tools

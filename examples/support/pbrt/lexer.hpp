#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "support/diagnostics.hpp"

namespace gmis::tools::pbrt {

struct Token {
  enum class Kind { word, number, string, open_bracket, close_bracket, end };
  Kind kind = Kind::end;
  std::string text;  ///< of a string: without its quotation marks, escapes resolved
  double number = 0;
  SourcePosition where;
};

/// Splits the text of one scene file into tokens. Throws `InputError` for a number that is not
/// finite and for a string that is not closed on its line.
class Lexer {
 public:
  Lexer(std::string text, const std::string& file_name);

  [[nodiscard]] const Token& peek();
  Token next();

  /// The word that stands first, without reading it; empty when something else stands there. To be
  /// asked before the first token is read, like `is_at_end` and `here`.
  [[nodiscard]] std::string_view first_word() const;
  [[nodiscard]] bool is_at_end() const { return position_ >= text_.size(); }
  [[nodiscard]] SourcePosition here() const { return {file_, line_}; }

 private:
  [[nodiscard]] Token read();
  [[nodiscard]] Token read_string();
  [[nodiscard]] Token read_word_or_number();
  void skip_space_and_comments();

  std::string text_;
  std::shared_ptr<const std::string> file_;
  std::size_t position_ = 0;
  int line_ = 1;
  Token ahead_;
  bool has_ahead_ = false;
};

/// The finite number that is all of `text`; false when it is anything else. A number too small for
/// a double is 0. Throws `InputError` for one that is too large.
[[nodiscard]] bool parse_number(std::string_view text, const SourcePosition& where, double& value);

}  // namespace gmis::tools::pbrt

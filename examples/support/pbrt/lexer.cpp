#include "support/pbrt/lexer.hpp"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <system_error>

namespace gmis::tools::pbrt {
namespace {

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f';
}

bool ends_word(char c) {
  return is_space(c) || c == '"' || c == '[' || c == ']' || c == '#';
}

}  // namespace

bool parse_number(std::string_view text, const SourcePosition& where, double& value) {
  if (text.empty()) return false;
  const bool has_plus = text.front() == '+';
  const std::string_view digits = has_plus ? text.substr(1) : text;
  const std::size_t first = digits.starts_with('-') ? 1 : 0;
  // from_chars would also read "inf" and "nan".
  if (first >= digits.size() || (has_plus && first == 1)) return false;
  if (digits[first] != '.' && (digits[first] < '0' || digits[first] > '9')) return false;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (end != digits.data() + digits.size()) return false;
  if (error == std::errc::result_out_of_range) {
    // Too small and too large look the same here; only the exponent's sign tells them apart.
    const std::size_t exponent = digits.find_first_of("eE");
    const bool is_small = exponent != std::string_view::npos && digits.substr(exponent + 1).starts_with('-');
    if (!is_small) throw InputError(where, "the number " + in_quotes(text) + " is too large: write one below 1e308");
    value = 0;
    return true;
  }
  return error == std::errc{} && std::isfinite(value);
}

Lexer::Lexer(std::string text, const std::string& file_name)
    : text_(std::move(text)), file_(std::make_shared<const std::string>(file_name)) {
  if (text_.starts_with("\xEF\xBB\xBF")) position_ = 3;  // the mark that some editors put before UTF-8
  skip_space_and_comments();
}

std::string_view Lexer::first_word() const {
  std::size_t end = position_;
  while (end < text_.size() && !ends_word(text_[end])) ++end;
  return std::string_view(text_).substr(position_, end - position_);
}

const Token& Lexer::peek() {
  if (!has_ahead_) {
    ahead_ = read();
    has_ahead_ = true;
  }
  return ahead_;
}

Token Lexer::next() {
  if (!has_ahead_) return read();
  has_ahead_ = false;
  return std::move(ahead_);
}

void Lexer::skip_space_and_comments() {
  while (position_ < text_.size()) {
    const char c = text_[position_];
    if (c == '#') {
      while (position_ < text_.size() && text_[position_] != '\n') ++position_;
    } else if (is_space(c)) {
      if (c == '\n') ++line_;
      ++position_;
    } else {
      return;
    }
  }
}

Token Lexer::read() {
  skip_space_and_comments();
  if (position_ >= text_.size()) return {Token::Kind::end, "", 0, here()};
  switch (text_[position_]) {
    case '[':
      ++position_;
      return {Token::Kind::open_bracket, "[", 0, here()};
    case ']':
      ++position_;
      return {Token::Kind::close_bracket, "]", 0, here()};
    case '"':
      return read_string();
    default:
      return read_word_or_number();
  }
}

Token Lexer::read_string() {
  Token token{Token::Kind::string, "", 0, here()};
  for (++position_; position_ < text_.size() && text_[position_] != '\n'; ++position_) {
    char c = text_[position_];
    if (c == '"') {
      ++position_;
      return token;
    }
    if (c == '\\' && position_ + 1 < text_.size()) {
      c = text_[++position_];
      if (c == '\n') break;
      if (c == 'n') c = '\n';
      if (c == 't') c = '\t';
      if (c == 'r') c = '\r';
    }
    token.text += c;
  }
  throw InputError(token.where, "the string " + in_quotes(token.text) + " is not closed on its line: add a '\"'");
}

Token Lexer::read_word_or_number() {
  const std::size_t start = position_;
  while (position_ < text_.size() && !ends_word(text_[position_])) ++position_;
  Token token{Token::Kind::word, text_.substr(start, position_ - start), 0, here()};
  if (parse_number(token.text, token.where, token.number)) token.kind = Token::Kind::number;
  return token;
}

}  // namespace gmis::tools::pbrt

#include "support/pbrt/lexer.hpp"

#include <string>
#include <vector>

#include "support/catch.hpp"
#include "support/message_of.hpp"

using gmis::tools::InputError;
using gmis::tools::pbrt::Lexer;
using gmis::tools::pbrt::Token;

namespace {

std::vector<Token> tokens_of(const std::string& text) {
  Lexer lexer(text, "a.pbrt");
  std::vector<Token> tokens;
  for (Token token = lexer.next(); token.kind != Token::Kind::end; token = lexer.next()) tokens.push_back(token);
  return tokens;
}

double number_in(const std::string& text) {
  const auto tokens = tokens_of(text);
  REQUIRE(tokens.size() == 1);
  REQUIRE(tokens[0].kind == Token::Kind::number);
  return tokens[0].number;
}

}  // namespace

TEST_CASE("Tokens come with their lines, comments left out") {
  const auto tokens = tokens_of("Shape \"sphere\" # a ball \" [\n\n  \"float radius\"[2 -3.5e1]true");
  REQUIRE(tokens.size() == 8);
  CHECK(tokens[0].text == "Shape");
  CHECK(tokens[0].where.to_string() == "a.pbrt:1");
  CHECK(tokens[1].kind == Token::Kind::string);
  CHECK(tokens[1].text == "sphere");
  CHECK(tokens[2].text == "float radius");
  CHECK(tokens[2].where.line == 3);
  CHECK(tokens[3].kind == Token::Kind::open_bracket);
  CHECK(tokens[4].number == 2.0);
  CHECK(tokens[5].number == -35.0);
  CHECK(tokens[6].kind == Token::Kind::close_bracket);
  CHECK(tokens[7].kind == Token::Kind::word);
}

TEST_CASE("Numbers are read to the last bit, in every notation that scene files use") {
  CHECK(number_in("+1") == 1.0);
  CHECK(number_in(".5") == 0.5);
  CHECK(number_in("-.5") == -0.5);
  CHECK(number_in("5.") == 5.0);
  CHECK(number_in("1E-2") == 0.01);
  CHECK(number_in("0.1") == 0.1);
  CHECK(number_in("1e-999") == 0.0);
}

TEST_CASE("What is no finite number is no number") {
  for (const char* text :
       {"nan", "NaN", "inf", "-inf", "infinity", "1e", "1.2.3", "0x10", "--1", "+-1", "+", "-", "1,5"}) {
    CAPTURE(text);
    CHECK(tokens_of(text).at(0).kind == Token::Kind::word);
  }
  CHECK_THROWS_AS(tokens_of("\n1e999"), InputError);
  CHECK_THROWS_AS(tokens_of("-1e400"), InputError);
}

TEST_CASE("Strings end on their line") {
  CHECK(tokens_of(R"("a\"b\\c")").at(0).text == "a\"b\\c");
  CHECK(tokens_of("\"\"").at(0).text.empty());
  CHECK_THROWS_AS(tokens_of("\"open"), InputError);
  CHECK_THROWS_AS(tokens_of("\"open\n\""), InputError);
  CHECK_THROWS_AS(tokens_of("\"open\\"), InputError);
  CHECK(gmis_test::message_of<InputError>([] { return tokens_of("Shape\n\n\"sphere"); }).find("a.pbrt:3: ") == 0);
}

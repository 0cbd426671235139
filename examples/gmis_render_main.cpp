#include "support/render_program.hpp"

int main(int argc, char** argv) {
  return gmis::tools::render_program(argc, argv);
}

#include "gmis/core/instruction_set.hpp"

int main() {}

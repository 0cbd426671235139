#include "all_headers.hpp"

// Every header as C++23.

static_assert(__cplusplus > 202002L);

int main() {
  return 0;
}

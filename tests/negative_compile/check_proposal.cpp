#include <gmis/core/density_tests.hpp>

#ifdef GMIS_EXPECT_OK
using Number = double;
#else
using Number = int;  // which has no bins of one width, and no integral
#endif

struct Drawn {
  Number sample(gmis::UniformSource auto& source) const { return static_cast<Number>(gmis::uniform<double>(source)); }
  double pdf(Number) const { return 1.0; }
};

int main() {
  gmis::Philox source(1);
  return gmis::check_proposal(Drawn{}, 0.0, 1.0, source).passes(1e-4) ? 0 : 1;
}

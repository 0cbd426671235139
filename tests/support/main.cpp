#include <cstdio>

#include "seed.hpp"

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using ListenerBase = Catch::EventListenerBase;
#else
#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
using ListenerBase = Catch::TestEventListenerBase;
#endif

namespace {

/// Says with a failure which seeds it was found with.
class SeedListener : public ListenerBase {
 public:
  using ListenerBase::ListenerBase;
  void testCaseEnded(Catch::TestCaseStats const& stats) override {
    if (stats.totals.assertions.failed == 0) return;
    std::fprintf(stderr, "Replay with GMIS_TEST_SEED=%llu\n", static_cast<unsigned long long>(gmis_test::run_seed()));
  }
};

}  // namespace

CATCH_REGISTER_LISTENER(SeedListener)

int main(int argc, char* argv[]) {
  return Catch::Session().run(argc, argv);
}

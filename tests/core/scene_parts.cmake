gmis_add_test(test_core_statistics statistics.cpp)
gmis_add_test(test_core_warp warp.cpp)

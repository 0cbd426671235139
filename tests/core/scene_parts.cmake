gmis_add_test(test_statistics statistics.cpp)
gmis_add_test(test_warp warp.cpp)

#include <gmis/gmis.hpp>
#include <iostream>

int main() {
  gmis::Philox random(7, 0, 0);
  double mean = 0;
  for (int i = 0; i < 1000; ++i) mean += gmis::uniform<double>(random) / 1000;
  std::cout << "mean of 1000 numbers: " << mean << '\n';
  return mean > 0.4 && mean < 0.6 ? 0 : 1;
}

#include "trackbed/par/comm.hpp"
int main(int argc, char** argv) {
  const trackbed::par::Environment environment(argc, argv);
  return 0;
}

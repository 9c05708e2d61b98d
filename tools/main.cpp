#include "engine/core/parallel.h"

int main(int, char** argv) { whorl::wait_passively(argv); }

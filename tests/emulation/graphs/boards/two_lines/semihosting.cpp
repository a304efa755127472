// The same calls as on the other emulated board.
#include "../../../../../boards/qemu_f405/semihosting.cpp"

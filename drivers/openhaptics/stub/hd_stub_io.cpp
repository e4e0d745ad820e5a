// The library that hd_stub_lonely needs.
extern "C" int hd_stub_io();
extern "C" int hd_stub_io() { return 42; }

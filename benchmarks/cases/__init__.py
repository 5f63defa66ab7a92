"""Cases with known answers: each is one small object, used by the tests and by the benchmarks alike."""

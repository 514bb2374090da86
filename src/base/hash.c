/* hash.c: computes checksums of data that must keep their bits. */
#include "base/base.h"

/* Mixes as splitmix64. */
uint64_t HashWord(uint64_t x)
{
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

uint64_t HashBytes(uint64_t seed, const void *data, size_t bytes)
{
  const char *at = data;
  uint64_t h = HashWord(seed ^ bytes), word;
  for (size_t i = 0; i < bytes; i += sizeof(word)) {
    word = 0;
    memcpy(&word, at + i, PetscMin(sizeof(word), bytes - i));
    h = HashWord(h ^ word);
  }
  return h;
}

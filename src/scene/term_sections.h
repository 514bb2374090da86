/* term_sections.h: sections of the scene that force terms have of their own. A term adds its line to
   TERM_SECTIONS and, below it, the file of its keys, which holds the struct of an entry under TERM_STRUCTS (a
   TermEntry comes first) and the rows of its keys under TERM_KEYS. The file is included once for each. */
#ifndef TERM_SECTIONS
#define TERM_SECTIONS(S) /* S(SECTION, "section of the scene", struct of an entry) */
#endif

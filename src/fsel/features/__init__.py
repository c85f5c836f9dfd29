"""The 18 features of a candidate (paper, section 3.2 and Appendix A.1), and what `fsel` adds."""

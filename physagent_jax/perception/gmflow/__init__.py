"""GMFlow (Xu et al. 2022, arXiv 2111.13680): optical flow as a search of the whole other picture."""

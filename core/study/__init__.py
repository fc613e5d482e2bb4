"""The paper's user study for any clips: design, web page and analysis (paper section 5.5)."""
